// Tests the start positions: columns and rows of equal mass.
#include "mesher/balance/initial_lattice_step.h"

#include <gtest/gtest.h>

#include <vector>

#include "mesher/balance/plan.h"
#include "tests/mesher/densities.h"

namespace hexrelief::balance {
namespace {

using namespace testing_mesher;

TEST(Start, PositionsOfSharesByHand) {
    // masses 1, 3, 0 (+ 1), 5
    const std::vector<std::int64_t> sums = {0, 1, 4, 5, 10};
    EXPECT_FLOAT_EQ(step::equalised(sums.data(), 4, 0.0f, 4), 0);
    EXPECT_FLOAT_EQ(step::equalised(sums.data(), 4, 0.05f, 4), 0.5f);
    EXPECT_FLOAT_EQ(step::equalised(sums.data(), 4, 0.25f, 4), 1.5f);
    EXPECT_FLOAT_EQ(step::equalised(sums.data(), 4, 0.45f, 4), 2.5f);
    EXPECT_FLOAT_EQ(step::equalised(sums.data(), 4, 0.75f, 4), 3.5f);
    EXPECT_FLOAT_EQ(step::equalised(sums.data(), 4, 1.0f, 4), 4);
    EXPECT_FLOAT_EQ(step::equalised(sums.data(), 4, 1.0f, 3.5f), 3.5f);
}

// Densities 9 : 1 in two halves: with a fifth spread evenly, their border is at (0.9 + 0.1) /
// 1.2 of the columns.
TEST(Start, AStepIsSolved) {
    DensityMap density = flat_density(120, 90);
    for (int y = 0; y < 90; ++y)
        for (int x = 60; x < 120; ++x) density.values[static_cast<std::size_t>(y) * 120 + x] = 1.0f / 9;
    MeshConfig config{.spacing_px = 2, .levels = 1};
    const som::LevelPlan plan = som::plan_levels(120, 90, config, {0, 0, 120, 90}).front();
    som::LatticePositions positions = som::regular_positions(plan);
    const som::LatticePositions regular = positions;
    equalise_start(plan, density.values, positions);
    int left = 0;
    for (std::size_t i = 0; i < positions.x.size(); ++i) {
        left += positions.x[i] < 60;
        EXPECT_NEAR(positions.y[i], regular.y[i], 1e-3);
    }
    EXPECT_NEAR(static_cast<double>(left) / static_cast<double>(positions.x.size()), 1 / 1.2, 0.01);
}

TEST(Start, FlatAndEmptyDensitiesStayRegular) {
    const som::LevelPlan plan = som::plan_levels(120, 90, {}, {0, 0, 120, 90}).front();
    for (const float value : {0.0f, 3.0f}) {
        som::LatticePositions positions = som::regular_positions(plan);
        const som::LatticePositions regular = positions;
        equalise_start(plan, std::vector<float>(static_cast<std::size_t>(plan.width) * plan.height, value),
                       positions);
        for (std::size_t i = 0; i < positions.x.size(); ++i) {
            EXPECT_NEAR(positions.x[i], regular.x[i], 1e-4);
            EXPECT_NEAR(positions.y[i], regular.y[i], 1e-4);
        }
    }
}

}  // namespace
}  // namespace hexrelief::balance
