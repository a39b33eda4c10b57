// Tests the paper baseline in cases in which its threads cannot race: with one active cell, or without moves.
#include "tests/cuda/paper/som.h"

#include <cmath>

#include "pipeline/data/error.h"
#include "tests/cuda/cuda_case.h"

namespace hexrelief::testing_cuda {
namespace {

using paper::Config;
using paper::Kernels;
using paper::Memory;

Config small_config(Kernels kernels, Memory memory) {
    return {.kernels = kernels,
            .memory = memory,
            .block_single = 8,
            .block_extraction = 256,
            .block_search = 1,
            .block_learning = 64,
            .t_max = 40,
            .sigma_init = 5,
            .ssr = 0,
            .crr = 1};
}

struct Point {
    double x, y;
};

// Applies Eq. 3 and 4 to a lattice with the single stimulus (px, py), in plain loops.
std::vector<Point> one_stimulus(int width, int height, double px, double py, const Config& config) {
    const int columns = static_cast<int>(std::lround(width / config.spacing_px));
    const int rows = static_cast<int>(std::lround(height / config.spacing_px));
    std::vector<Point> w;
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c)
            w.push_back({(c + 0.25 + 0.5 * (r % 2)) * width / columns, (r + 0.5) * height / rows});
    for (int t = 0; t < config.t_max; ++t) {
        const double share = static_cast<double>(t) / config.t_max;
        const double alpha = config.alpha_init * std::pow(config.alpha_final / config.alpha_init, share);
        const double sigma = config.sigma_init * std::pow(config.sigma_final / config.sigma_init, share);
        std::size_t winner = 0;
        const auto distance = [&](std::size_t i) { return std::hypot(w[i].x - px, w[i].y - py); };
        for (std::size_t i = 1; i < w.size(); ++i)
            if (distance(i) < distance(winner)) winner = i;
        const int wr = static_cast<int>(winner) / columns, wc = static_cast<int>(winner) % columns;
        for (int r = 0; r < rows; ++r)
            for (int c = 0; c < columns; ++c) {
                // steps along rows are the rest of the columns, after half a column for each row
                const double dx = std::abs((c + 0.5 * (r % 2)) - (wc + 0.5 * (wr % 2))),
                             dy = std::abs(r - wr);
                const double d = dy + std::max(0.0, dx - 0.5 * dy);
                if (d > std::floor(sigma)) continue;
                const double gain = alpha * std::exp(-d * d / (sigma * sigma));
                Point& p = w[static_cast<std::size_t>(r) * columns + c];
                p = {p.x + gain * (px - p.x), p.y + gain * (py - p.y)};
            }
    }
    return w;
}

class PaperSom : public ::testing::TestWithParam<std::tuple<Kernels, Memory>> {};

TEST_P(PaperSom, FollowsEquation3WhereOneCellIsActive) {
    HEXRELIEF_NEEDS_DEVICE();
    const auto [kernels, memory] = GetParam();
    Config config = small_config(kernels, memory);
    config.alpha_init = 0.4;  // at 1 the winner would be on the point, and two winners could tie for it
    const DensityMap density = testing_mesher::bright_pixel_density(150, 132, 71, 40);
    paper::Som som;
    const paper::Result result = som.train(density, config);
    const std::vector<Point> expected = one_stimulus(150, 132, 71.5, 40.5, config);
    ASSERT_EQ(result.mesh.positions.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        ASSERT_NEAR(result.mesh.positions[i].x, expected[i].x, 0.02) << i;
        ASSERT_NEAR(result.mesh.positions[i].y, expected[i].y, 0.02) << i;
    }
    EXPECT_GT(result.som_s, 0);
    EXPECT_GT(result.device_bytes, 0u);
    EXPECT_EQ(result.escaped, 0);
}

TEST_P(PaperSom, TimesItsKernels) {
    HEXRELIEF_NEEDS_DEVICE();
    const auto [kernels, memory] = GetParam();
    Config config = small_config(kernels, memory);
    config.time_kernels = true;
    config.random_reuse = 7;  // several fillings, the last one short
    paper::Som som;
    const paper::Result result = som.train(testing_mesher::bumps_density(150, 132), config);
    const double sum = result.single_s + result.extraction_s + result.search_s + result.learning_s;
    EXPECT_GT(sum, 0);
    EXPECT_LE(sum, result.som_s);
    EXPECT_EQ(result.single_s > 0, kernels == Kernels::single);
    EXPECT_EQ(result.search_s > 0, kernels == Kernels::multiple);
}

INSTANTIATE_TEST_SUITE_P(Cuda, PaperSom,
                         ::testing::Combine(::testing::Values(Kernels::single, Kernels::multiple),
                                            ::testing::Values(Memory::version1, Memory::version2,
                                                              Memory::version2_texture)));

TEST(CudaPaper, NothingMovesWithoutDensity) {
    HEXRELIEF_NEEDS_DEVICE();
    paper::Som som;
    const Config config = small_config(Kernels::single, Memory::version2);
    const paper::Result result = som.train(testing_mesher::flat_density(90, 80, 0), config);
    const std::vector<Point> regular = one_stimulus(90, 80, 0, 0, [&] {
        Config still = config;
        still.t_max = 0;
        return still;
    }());
    for (std::size_t i = 0; i < regular.size(); ++i)
        EXPECT_NEAR(result.mesh.positions[i].x, regular[i].x, 1e-3) << i;
}

TEST(CudaPaper, MovesTowardsWhatIsDense) {
    HEXRELIEF_NEEDS_DEVICE();
    DensityMap density = testing_mesher::flat_density(300, 240, 0.01f);
    for (int y = 0; y < 240; ++y)
        for (int x = 200; x < 300; ++x) density.values[static_cast<std::size_t>(y) * 300 + x] = 1;
    Config config = small_config(Kernels::single, Memory::version2_texture);
    config.t_max = 400;
    config.ssr = 4;
    paper::Som som;
    double sum = 0;
    const paper::Result result = som.train(density, config);
    for (const Vec2f& p : result.mesh.positions) sum += p.x;
    EXPECT_GT(sum / static_cast<double>(result.mesh.positions.size()), 180);
}

TEST(CudaPaper, RefusesBlocksOutOfRange) {
    HEXRELIEF_NEEDS_DEVICE();
    Config config{.block_single = 1025};
    paper::Som som;
    EXPECT_THROW(som.train(testing_mesher::flat_density(90, 80), config), Error);
}

}  // namespace
}  // namespace hexrelief::testing_cuda
