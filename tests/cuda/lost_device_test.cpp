// Tests a device that is lost in the middle of a run, after which the driver refuses all calls, or that is
// released. Each test is a process of its own, because no other test could use the device afterwards.
#include <filesystem>
#include <iostream>

#include "cuda/som/level.h"
#include "pipeline/job/backend.h"
#include "tests/cuda/cuda_case.h"

namespace hexrelief::testing_cuda {
namespace {

const DensityMap& density() {
    static const DensityMap made = testing_mesher::bumps_density(200, 150);
    return made;
}

// Lets a kernel read at an invalid address: from then on the driver refuses all work of this
// process on the device.
void lose_device() {
    cuda::coarsen({}, nullptr, 64, 64, nullptr);
    cudaDeviceSynchronize();
}

// Returns a callback that loses the device at the first report of progress.
ProgressFunction losing_progress() {
    return [lost = false](double) mutable {
        if (!lost) lose_device();
        lost = true;
    };
}

void expect_device_error(const char* what, const std::function<void()>& work) {
    try {
        work();
    } catch (const Error& error) {
        if (error.kind() == ErrorKind::device && std::string(error.what()).find('\n') == std::string::npos)
            return;
        std::cerr << "another error: " << error.what() << "\n";
        std::_Exit(1);
    }
    std::cerr << "no error: " << what << "\n";
    std::_Exit(1);
}

// Each call to a lost device is refused in one line, and its resources can be released.
[[noreturn]] void everything_is_refused() {
    {
        cuda::CudaMesher mesher;
        const MeshConfig config = balanced_config(20);
        expect_device_error("the run that lost it",
                            [&] { mesher.solve(density(), config, losing_progress()); });
        expect_device_error("the next run", [&] { mesher.solve(density(), config, {}); });
        expect_device_error("another context",
                            [] { cuda::CudaMesher().solve(density(), quick_config(3), {}); });
    }
    std::cerr << "all was refused\n";
    std::_Exit(0);
}

// The device's solver, whose first run loses the device.
class LosingBackend final : public job::Backend {
  public:
    LosingBackend() : Backend(2) {}
    std::string name() const override { return "cuda"; }
    std::string device() const override { return "lost"; }
    matching::MatchedMap match_pair(const StereoPair&, const matching::MatchingConfig&) override {
        return {};
    }
    HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config,
                         const ProgressFunction&) override {
        return mesher_.solve(density, config, losing_progress());
    }
    DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput&, const SurfaceConfig&) override {
        return {};
    }
    void balance_patch(const DensityMap&, const BalanceConfig&, balance::LatticePatch&) override {}

  private:
    cuda::CudaMesher mesher_;
};

// Under `auto` the run that loses the device ends on the CPU, with the same bytes, and so do those after it.
[[noreturn]] void the_cpu_goes_on() {
    bool same = true;
    {
        job::RunLog log;
        log.warns = [](const std::string& warning) { std::cerr << warning << "\n"; };
        const job::BackendPointer both = job::with_replacement(
            std::make_shared<LosingBackend>(), job::pick_backend(config::BackendChoice::cpu, 2), log);
        const MeshConfig config = balanced_config(20);
        const HexMesh2D expected = mesher::solve_mesh(density(), config, 2, {});
        for (int i = 0; i < 2; ++i)
            same = same && same_bytes(both->solve_mesh(density(), config, {}), expected);
        same = same && both->is_replaced();
    }
    std::_Exit(same ? 0 : 1);
}

// Reports the driver's files that are still open after end_cuda().
[[noreturn]] void the_driver_is_let_go() {
    const auto open_files = [] {
        int count = 0;
        for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd"))
            count += std::filesystem::read_symlink(file).string().starts_with("/dev/nvidia");
        return count;
    };
    int before = 0;
    {
        cuda::CudaMesher mesher;
        mesher.solve(density(), quick_config(3), {});
        before = open_files();
    }
    cuda::end_cuda();
    std::_Exit(before > 0 && open_files() == 0 ? 0 : 1);
}

TEST(CudaLostDeviceDeathTest, RefusesEverythingInOneLine) {
    HEXRELIEF_NEEDS_DEVICE();
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(everything_is_refused(), testing::ExitedWithCode(0), "all was refused");
}

TEST(CudaLostDeviceDeathTest, UnderAutoTheCpuGoesOn) {
    HEXRELIEF_NEEDS_DEVICE();
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(the_cpu_goes_on(), testing::ExitedWithCode(0),
                "backend cuda: .*illegal memory access.*; the CPU goes on");
}

TEST(CudaLostDeviceDeathTest, LetsTheDriverGo) {
    HEXRELIEF_NEEDS_DEVICE();
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(the_driver_is_let_go(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace hexrelief::testing_cuda
