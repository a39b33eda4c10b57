// Tests parts of a lattice with held vertices: the CPU's and CUDA's bytes are the same.
#include <random>

#include "mesher/som/level_transfer_step.h"
#include "pipeline/data/error.h"
#include "tests/cuda/cuda_case.h"

namespace hexrelief::testing_cuda {
namespace {

enum class Held { none, some, most, all, frame };

// Returns a regular lattice over the density whose vertices are displaced by up to `jitter` spacings.
balance::LatticePatch made_up_patch(const DensityMap& density, step::Lattice lattice, float jitter, Held held,
                                    unsigned seed) {
    std::mt19937 random(seed);
    const auto share = [&] { return static_cast<float>(random() / 4294967296.0); };
    const float width = static_cast<float>(density.width), height = static_cast<float>(density.height);
    const float dx = width / static_cast<float>(lattice.columns),
                dy = height / static_cast<float>(lattice.rows);
    balance::LatticePatch patch{{lattice.columns, lattice.rows, {}}, {}};
    for (int row = 0; row < lattice.rows; ++row)
        for (int column = 0; column < lattice.columns; ++column) {
            const float x = step::regular_x(column, row, lattice.columns, width) +
                            jitter * dx * (share() - 0.5f),
                        y = step::regular_y(row, lattice.rows, height) + jitter * dy * (share() - 0.5f);
            patch.mesh.positions.push_back({std::clamp(x, 0.0f, width), std::clamp(y, 0.0f, height)});
            const int rings = std::min({column, row, lattice.columns - 1 - column, lattice.rows - 1 - row});
            const bool stays = held == Held::all || (held == Held::frame && rings < 4) ||
                               (held == Held::some && share() < 0.1f) ||
                               (held == Held::most && share() < 0.8f);
            patch.held.push_back(stays ? 1 : 0);
        }
    return patch;
}

void expect_same_patch(const DensityMap& density, const BalanceConfig& config,
                       const balance::LatticePatch& patch, const std::string& what) {
    balance::LatticePatch cpu = patch, cuda = patch;
    balance::balance_patch(density, config, 2, cpu);
    shared_mesher()->balance_patch(density, config, cuda);
    EXPECT_EQ(cuda.held, patch.held);
    ASSERT_EQ(cpu.mesh.positions.size(), cuda.mesh.positions.size());
    EXPECT_EQ(std::memcmp(cpu.mesh.positions.data(), cuda.mesh.positions.data(),
                          cpu.mesh.positions.size() * sizeof(Vec2f)),
              0)
        << what;
}

void expect_same_patches(const DensityMap& density, step::Lattice lattice, int iterations) {
    BalanceConfig config{.iterations = iterations};
    unsigned seed = 0;
    for (const Held held : {Held::none, Held::some, Held::most, Held::all, Held::frame})
        for (const float jitter : {0.2f, 1.5f})  // the second one folds the lattice
            expect_same_patch(density, config, made_up_patch(density, lattice, jitter, held, ++seed),
                              std::to_string(lattice.columns) + " x " + std::to_string(lattice.rows) +
                                  ", held " + std::to_string(static_cast<int>(held)) + ", jitter " +
                                  std::to_string(jitter));
}

// Small enough for the sanitizers: by a block and a cluster.
TEST(CudaSmall, PatchOfALattice) {
    HEXRELIEF_NEEDS_DEVICE();
    const DensityMap density = testing_mesher::bumps_density(91, 73);
    BalanceConfig config{.iterations = 1};
    expect_same_patch(density, config, made_up_patch(density, {23, 19}, 0.5f, Held::some, 1), "block");
    expect_same_patch(density, config, made_up_patch(density, {45, 37}, 0.5f, Held::frame, 2), "cluster");
}

TEST(CudaPatch, OfTheLeastSizes) {
    HEXRELIEF_NEEDS_DEVICE();
    const DensityMap density = testing_mesher::noise_density(29, 31, 5);
    for (const step::Lattice lattice :
         {step::Lattice{1, 1}, {2, 1}, {1, 5}, {2, 2}, {3, 2}, {3, 3}, {4, 3}, {4, 4}, {5, 3}, {7, 6}})
        expect_same_patches(density, lattice, 3);
}

TEST(CudaPatch, InABlock) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_same_patches(testing_mesher::bumps_density(120, 90), {27, 24}, 4);
    expect_same_patches(testing_mesher::noise_density(120, 90, 3), {31, 20}, 4);
}

TEST(CudaPatch, InACluster) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_same_patches(testing_mesher::bumps_density(500, 421), {121, 105}, 4);
}

TEST(CudaPatch, InAGrid) {
    HEXRELIEF_NEEDS_DEVICE();
    // one cell per thread
    expect_same_patches(testing_mesher::bumps_density(900, 703), {223, 175}, 3);
    // several
    expect_same_patches(testing_mesher::noise_density(1800, 1403, 7), {601, 467}, 1);
}

// The shape of a seam, which lies along a border of tiles.
TEST(CudaPatch, LongAndNarrow) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_same_patches(testing_mesher::bumps_density(4000, 150), {1333, 49}, 2);
    expect_same_patches(testing_mesher::bumps_density(150, 4000), {49, 1333}, 2);
}

TEST(CudaPatch, WithoutDensity) {
    HEXRELIEF_NEEDS_DEVICE();
    expect_same_patches(testing_mesher::flat_density(90, 80, 0), {25, 22}, 3);
    expect_same_patches(testing_mesher::bright_pixel_density(150, 150, 149, 0), {60, 50}, 3);
}

TEST(CudaPatch, AfterAndBeforeOtherWork) {
    HEXRELIEF_NEEDS_DEVICE();
    const DensityMap density = testing_mesher::bumps_density(300, 200);
    for (int i = 0; i < 3; ++i) {
        expect_equal(density, balanced_config(2));
        expect_same_patches(density, {75, 58}, 2);
    }
}

TEST(CudaPatch, StaysAsItIsWhereTheDeviceCannot) {
    HEXRELIEF_NEEDS_DEVICE();
    const DensityMap density = testing_mesher::bumps_density(90, 80);
    const balance::LatticePatch before = made_up_patch(density, {25, 22}, 1.5f, Held::some, 1);
    balance::LatticePatch patch = before;
    BalanceConfig config{.sweeps = 101};
    EXPECT_THROW(shared_mesher()->balance_patch(density, config, patch), Error);
    EXPECT_EQ(patch.mesh.positions, before.mesh.positions);
}

}  // namespace
}  // namespace hexrelief::testing_cuda
