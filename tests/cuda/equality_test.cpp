// Tests that CPU bytes == CUDA bytes, and that both == the plain-loop oracle.
#include <cstdlib>
#include <functional>
#include <random>

#include "tests/cuda/cuda_case.h"
#include "tests/mesher/naive_som.h"

namespace hexrelief::testing_cuda {
namespace {

// Clears all except a rectangle from (x, y) on, at most two thirds of the image in each direction.
void clear_frame(DensityMap& density, int x, int y) {
    for (int row = 0; row < density.height; ++row)
        for (int column = 0; column < density.width; ++column)
            if (column < x || column >= x + density.width * 2 / 3 || row < y ||
                row >= y + density.height * 2 / 3)
                density.values[static_cast<std::size_t>(row) * density.width + column] = 0;
}

DensityMap framed(DensityMap density, int x, int y) {
    clear_frame(density, x, y);
    return density;
}

// Returns a density of 1 that drops to 0.01 at a third of the width: the coarsest level
// takes all its iterations.
DensityMap step_density(int width, int height) {
    DensityMap density = testing_mesher::flat_density(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = width / 3; x < width; ++x)
            density.values[static_cast<std::size_t>(y) * width + x] = x * 3 > y * 2 ? 0.01f : 1.0f;
    return density;
}

// The test that runs makes the density: each test is a process of its own, which lists all of them.
struct EqualityCase {
    std::string name;
    std::function<DensityMap()> make;

    friend void PrintTo(const EqualityCase& d, std::ostream* out) { *out << d.name; }
};

std::vector<EqualityCase> cases() {
    using namespace testing_mesher;
    return {{"Bumps", [] { return testing_mesher::bumps_density(211, 163); }},
            {"Ramp", [] { return testing_mesher::ramp_density(160, 150); }},
            {"Noise", [] { return testing_mesher::noise_density(150, 131, 4); }},
            {"BrightPixel", [] { return testing_mesher::bright_pixel_density(150, 150, 149, 0); }},
            {"Nothing", [] { return testing_mesher::flat_density(90, 80, 0); }},
            {"Flat", [] { return testing_mesher::flat_density(240, 180); }},
            {"Framed", [] { return framed(testing_mesher::bumps_density(260, 190), 71, 33); }},
            {"Step", [] { return step_density(290, 240); }},
            {"Leaves", [] { return testing_mesher::leaves_density(300, 240, false); }},
            {"HangingLeaves", [] { return testing_mesher::leaves_density(1301, 1103, true); }},
            {"TwoDiscs", [] { return testing_mesher::two_discs_density(450, 375); }},
            {"TwoDiscsLarge", [] { return testing_mesher::two_discs_density(1301, 1103); }},
            {"ThreeByThree", [] { return testing_mesher::bumps_density(18, 19); }},
            {"OneRowOfCells", [] { return testing_mesher::bumps_density(333, 20); }},
            {"OneColumnOfCells", [] { return testing_mesher::bumps_density(20, 333); }},
            {"OddSize", [] { return testing_mesher::noise_density(457, 379, 9); }},
            {"LargeLevel", [] { return testing_mesher::bumps_density(1301, 1103); }}};
}

class Equality : public ::testing::TestWithParam<EqualityCase> {};

TEST_P(Equality, DefaultSchedule) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal(GetParam().make(), quick_config(25));
}

TEST_P(Equality, PaperSchedule) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal(GetParam().make(), paper_config(90));
}

TEST_P(Equality, Balanced) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal(GetParam().make(), balanced_config(6));
}

// With the default's iterations, which end a level early or late.
TEST_P(Equality, Default) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal(GetParam().make(), {});
}

TEST_P(Equality, BalancedWithAFreeBorder) {
    HEXRELIEF_NEEDS_DEVICE();
    MeshConfig config = balanced_config(4);
    config.border = MeshBorder::free;
    config.magnification = 1;
    expect_equal(GetParam().make(), config);
}

// A single level has folds that a coarse-to-fine run does not have.
TEST_P(Equality, BalancedOnOneLevel) {
    HEXRELIEF_NEEDS_DEVICE();
    MeshConfig config = balanced_config(5);
    config.levels = 1;
    config.t_max = 2;
    config.alpha_final = 1;
    config.sigma_init = config.sigma_final = 0.5;
    expect_equal(GetParam().make(), config);
}

INSTANTIATE_TEST_SUITE_P(Cuda, Equality, ::testing::ValuesIn(cases()),
                         [](const auto& i) { return i.param.name; });

// Small enough for the sanitizers: a map that fits a cluster, one that does not, and balancing by a block, a
// cluster and the grid.
TEST(CudaSmall, Cluster) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal(testing_mesher::bumps_density(101, 83), quick_config(12));
}

TEST(CudaSmall, LargeLevel) {
    HEXRELIEF_NEEDS_DEVICE();
    MeshConfig config = quick_config(6);
    config.levels = 1;
    config.delta = 64;  // more points than a small level may have
    config.crr = 4;
    expect_equal(testing_mesher::bumps_density(301, 283), config);
}

TEST(CudaSmall, BalanceInABlock) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal(testing_mesher::bumps_density(91, 73), balanced_config(2));
}

TEST(CudaSmall, BalanceInACluster) {
    HEXRELIEF_NEEDS_DEVICE();
    MeshConfig config = balanced_config(2);
    config.levels = 1;
    config.spacing_px = 3;
    expect_equal(testing_mesher::bumps_density(181, 170), config);
}

TEST(CudaSmall, BalanceInAGrid) {
    HEXRELIEF_NEEDS_DEVICE();
    MeshConfig config = balanced_config(1);
    config.levels = 1;
    config.spacing_px = 2;
    config.balance.sweeps = 3;
    expect_equal(testing_mesher::bumps_density(301, 283), config);
}

TEST(CudaSmall, BalanceWithBentEnds) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_equal(testing_mesher::leaves_density(120, 96, false), balanced_config(3));
    expect_equal(testing_mesher::two_discs_density(120, 96), balanced_config(3));
}

TEST(CudaOracle, PlainLoopsGiveTheSame) {
    HEXRELIEF_NEEDS_DEVICE();
    for (const DensityMap& density :
         {testing_mesher::bumps_density(60, 48), testing_mesher::noise_density(160, 150, 2)})
        for (const MeshConfig& config : {quick_config(20), paper_config(40)}) {
            const HexMesh2D cuda = shared_mesher()->solve(density, config, {});
            const testing_mesher::NaiveResult naive = testing_mesher::naive_som(density, config);
            EXPECT_EQ(naive.mesh.positions, cuda.positions) << testing_mesher::describe(density, config);
        }
}

TEST(CudaRandom, HundredConfigurations) {
    HEXRELIEF_NEEDS_DEVICE();
    std::mt19937 random(2026);
    const auto pick = [&](int low, int high) {
        return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
    };
    for (int k = 0; k < 100; ++k) {
        MeshConfig config = quick_config(1);
        config.spacing_px = pick(2, 9);
        config.levels = pick(0, 4);
        config.t_max = pick(1, 30);
        config.alpha_init = pick(1, 10) / 10.0;
        config.sigma_init = pick(5, 200) / 10.0;
        config.sigma_level_init = pick(5, 80) / 10.0;
        config.co = pick(2, 40);
        config.delta = pick(1, 60) / 10.0;
        config.ssr = pick(0, 5);
        config.crr = pick(1, 25);
        config.prr = pick(1, 16);
        config.prr_final = pick(0, 32);
        config.magnification = pick(0, 1) ? 1.0 : 1.3;
        config.border = pick(0, 1) ? MeshBorder::free : pick(0, 1) ? MeshBorder::slide : MeshBorder::fit;
        config.seed = random();
        config.balance.enabled = k % 2 == 1;
        config.balance.iterations = pick(1, 8);
        config.balance.sweeps = pick(2, 30);
        config.balance.least_angle_deg = pick(1, 30);
        config.balance.floor = pick(1, 500) / 1000.0;
        const int width = pick(30, 320), height = pick(30, 320);
        DensityMap density = pick(0, 1) ? testing_mesher::bumps_density(width, height)
                                        : testing_mesher::noise_density(width, height, random());
        if (k % 5 == 1) density = testing_mesher::leaves_density(width, height, pick(0, 1));
        if (k % 5 == 3) density = testing_mesher::two_discs_density(width, height);
        if (k % 3 == 0) clear_frame(density, pick(0, width / 2), pick(0, height / 2));
        expect_equal(density, config);
        if (::testing::Test::HasFailure()) return;
    }
}

// HEXRELIEF_REPEATS runs (20 if it is not set) of one map give one result.
TEST(CudaRepeats, EveryRunGivesTheSameBytes) {
    HEXRELIEF_NEEDS_DEVICE();
    const char* const repeats = std::getenv("HEXRELIEF_REPEATS");
    for (const DensityMap& density :
         {testing_mesher::bumps_density(451, 375), testing_mesher::noise_density(901, 751, 5)}) {
        for (const MeshConfig& config : {quick_config(80), MeshConfig{}}) {
            const HexMesh2D first = shared_mesher()->solve(density, config, {});
            for (int k = 1; k < (repeats ? std::atoi(repeats) : 20); ++k)
                ASSERT_TRUE(same_bytes(first, shared_mesher()->solve(density, config, {}))) << "run " << k;
        }
    }
}

}  // namespace
}  // namespace hexrelief::testing_cuda
