// Tests the calls that the backend refuses, and their messages.
#include "pipeline/data/error.h"
#include "tests/cuda/cuda_case.h"
#include "tests/expect_error.h"

namespace hexrelief::testing_cuda {
namespace {

TEST(CudaDevice, NoDeviceSaysWhyAndWhatToDo) {
    if (shared_mesher()) GTEST_SKIP() << "there is a CUDA device here";
    std::string why;
    EXPECT_TRUE(cuda::list_cuda_devices(&why).empty());
    EXPECT_FALSE(why.empty());
    const std::string message = test::error_of([] { cuda::CudaMesher mesher; }, ErrorKind::device);
    EXPECT_NE(message.find(why), std::string::npos) << message;
    EXPECT_NE(message.find("--backend cpu"), std::string::npos) << message;
}

TEST(CudaDevice, RefusesTheSequentialMethod) {
    HEXRELIEF_NEEDS_DEVICE();
    MeshConfig config = quick_config(3);
    config.method = MeshMethod::sequential;
    const DensityMap density = testing_mesher::flat_density(60, 60);
    const std::string message =
        test::error_of([&] { shared_mesher()->solve(density, config, {}); }, ErrorKind::usage);
    EXPECT_NE(message.find("mesh.method"), std::string::npos) << message;
}

TEST(CudaDevice, RefusesRadiiBeyondItsTables) {
    HEXRELIEF_NEEDS_DEVICE();
    MeshConfig config = paper_config(3);
    config.sigma_init = 40;
    const DensityMap density = testing_mesher::flat_density(700, 700);
    const std::string message =
        test::error_of([&] { shared_mesher()->solve(density, config, {}); }, ErrorKind::device);
    EXPECT_NE(message.find("sigma_init"), std::string::npos) << message;
}

TEST(CudaDevice, KeepsItsContextAfterAnError) {
    HEXRELIEF_NEEDS_DEVICE();
    MeshConfig config = paper_config(3);
    config.sigma_init = 40;
    const DensityMap large = testing_mesher::flat_density(700, 700),
                     small = testing_mesher::bumps_density(90, 80);
    EXPECT_THROW(shared_mesher()->solve(large, config, {}), Error);
    expect_equal(small, quick_config(10));
}

}  // namespace
}  // namespace hexrelief::testing_cuda
