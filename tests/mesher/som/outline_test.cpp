// Tests the lattice's upper and lower border if they bend into empty valleys.
#include "mesher/som/outline_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesher/balance/balance.h"
#include "mesher/quality/quality.h"
#include "mesher/som/level_plan.h"
#include "mesher/som/untangle_step.h"
#include "tests/mesher/densities.h"

namespace hexrelief::som {
namespace {

using namespace testing_mesher;

constexpr int kWidth = 300, kHeight = 240;
constexpr MeshArea kWhole{0, 0, kWidth, kHeight};

DensityMap leaves(bool hanging) {
    return leaves_density(kWidth, kHeight, hanging);
}

bool is_filled(const DensityMap& density, int x, int y) {
    return x >= 0 && x < density.width && density.at(x, y) > 0;
}

TEST(Outline, KeepsOutsideOfAllDensityAndBendsSoftly) {
    const DensityMap density = leaves(false);
    const MeshOutline outline = mesh_outline(density, kWhole, {});
    ASSERT_EQ(outline.upper.size(), kWidth + 1u);
    ASSERT_EQ(outline.lower.size(), kWidth + 1u);
    for (int x = 0; x <= kWidth; ++x) {
        EXPECT_GE(outline.upper[x], 0);
        EXPECT_LE(outline.upper[x], kHeight / 4);
        EXPECT_EQ(outline.lower[x], kHeight);
        for (int y = 0; y < outline.upper[x]; ++y)
            ASSERT_FALSE(is_filled(density, x - 1, y) || is_filled(density, x, y)) << x << ' ' << y;
        if (x > 0) {
            EXPECT_LE(std::abs(outline.upper[x] - outline.upper[x - 1]), 1.401f);
        }
    }
    EXPECT_GT(*std::max_element(outline.upper.begin(), outline.upper.end()), kHeight / 6);
    EXPECT_EQ(outline.upper[166], 0);  // the tip of the second leaf
}

TEST(Outline, HangsTheOtherWayRound) {
    const MeshOutline standing = mesh_outline(leaves(false), kWhole, {}),
                      hanging = mesh_outline(leaves(true), kWhole, {});
    for (int x = 0; x <= kWidth; ++x) EXPECT_EQ(hanging.lower[x], kHeight - standing.upper[x]);
}

TEST(Outline, IsStraightWhereNothingIsEmptyOrNotAskedFor) {
    const auto straight = [](const DensityMap& density, const MeshConfig& config) {
        return mesh_outline(density, kWhole, config).upper.empty();
    };
    MeshConfig config;
    EXPECT_TRUE(straight(flat_density(kWidth, kHeight), config));
    EXPECT_TRUE(straight(noise_density(kWidth, kHeight, 3), config));
    EXPECT_FALSE(straight(leaves(false), config));
    config.border = MeshBorder::slide;
    EXPECT_TRUE(straight(leaves(false), config));
    config.border = MeshBorder::free;
    EXPECT_TRUE(straight(leaves(false), config));
    config.border = MeshBorder::fit;
    config.balance.enabled = false;
    EXPECT_TRUE(straight(leaves(false), config));
}

TEST(Outline, CurvesOnCoarserLevels) {
    const MeshOutline outline{{0, 8, 16, 4, 0}, {40, 40, 24, 40, 40}};
    const step::Outline finest = outline_of(outline, outline.upper.data(), outline.lower.data(), 0),
                        third = outline_of(outline, outline.upper.data(), outline.lower.data(), 2);
    EXPECT_EQ(step::curve_at(finest, finest.upper, 1.5f), 12);
    EXPECT_EQ(step::curve_at(third, third.upper, 0.375f), 3);
    EXPECT_EQ(step::curve_at(finest, finest.upper, -5), 0);
    EXPECT_EQ(step::curve_at(finest, finest.lower, 9), 40);
    EXPECT_EQ(step::curve_slope(finest, finest.upper, 0.5f), 8);
    EXPECT_EQ(step::y_of_share(finest, 2, 0.25f), 18);
    EXPECT_EQ(step::share_of(finest, 2, 18), 0.25f);
    EXPECT_FALSE(step::is_bent(outline_of({}, nullptr, nullptr, 0)));
    // an edge from (1, 8) to (3, 4) passes above the valley; the one from (2, 16) to (4, 0) cuts off 4 px of
    // the region at x = 3
    EXPECT_EQ(step::cut_off(finest, 0, {1, 8}, {3, 4}), 0);
    EXPECT_EQ(step::cut_off(finest, 0, {2, 16}, {4, 0}), 4);
    EXPECT_EQ(step::cut_off(finest, 1, {1, 40}, {3, 40}), 0);
    EXPECT_EQ(step::cut_off(finest, 1, {0, 40}, {2, 24}), 8);
    EXPECT_EQ(step::cut_off(finest, 0, {3, 4}, {3, 4}), 0);
}

// Returns y of the lattice's first or last row at x.
double end_at(const HexMesh2D& mesh, int row, double x) {
    for (int column = 0; column + 1 < mesh.columns; ++column) {
        const Vec2f &a = mesh.at(column, row), &b = mesh.at(column + 1, row);
        if (a.x <= x && x < b.x) return a.y + (x - a.x) / (b.x - a.x) * (b.y - a.y);
    }
    return mesh.at(mesh.columns - 1, row).y;
}

TEST(Outline, MeshHoldsAllDensityAndNoEmptyValley) {
    for (const bool hanging : {false, true}) {
        const DensityMap density = leaves(hanging);
        const HexMesh2D mesh = solve(density, {});
        const quality::MeshQuality quality = quality::measure_quality(mesh, density, 1);
        std::printf("leaves: %%cost %.2f, 1st percentile angle %.2f deg\n", quality.percent_cost,
                    quality.percentile1_angle_deg);
        EXPECT_LE(quality.percent_cost, 3);  // 4.2 to 5.0 with a straight border
        EXPECT_GE(quality.percentile1_angle_deg, 8);
        EXPECT_EQ(quality.inverted_triangles, 0);
        double deepest = 0;
        for (int x = 0; x < kWidth; ++x) {
            const double upper = end_at(mesh, 0, x + 0.5), lower = end_at(mesh, mesh.rows - 1, x + 0.5);
            deepest = std::max(deepest, hanging ? kHeight - lower : upper);
            for (int y = 0; y < kHeight; ++y)
                if (density.at(x, y) > 0) {
                    ASSERT_GE(y + 0.5, upper - 0.01) << x;
                    ASSERT_LE(y + 0.5, lower + 0.01) << x;
                }
        }
        EXPECT_GT(deepest, kHeight / 6);
    }
}

// An unfolded lattice whose rows climb stays unfolded when it is refined: all rows begin on the
// border, shifted or not.
TEST(Prolongation, KeepsASlantedLatticeUnfolded) {
    const step::Lattice coarse{16, 14}, fine{32, 28};
    constexpr float kExtent = 100;
    LatticePositions from, to;
    for (int row = 0; row < coarse.rows; ++row)
        for (int column = 0; column < coarse.columns; ++column) {
            float x = step::regular_x(column, row, coarse.columns, kExtent),
                  y = step::regular_y(row, coarse.rows, kExtent);
            step::pin_to_border({coarse, {}, kExtent, kExtent}, column, row, x, y);
            from.x.push_back(x);
            from.y.push_back(y - 0.8f * std::min(x, 30.0f) * std::sin(3.14159265f * y / kExtent));
        }
    const step::LatticeView before{coarse.columns, coarse.rows, from.x.data(), from.y.data()};
    for (int row = 0; row < coarse.rows; ++row)
        for (int column = 0; column < coarse.columns; ++column)
            ASSERT_FALSE(step::folded(before, column, row)) << column << ' ' << row;
    for (int row = 0; row < fine.rows; ++row)
        for (int column = 0; column < fine.columns; ++column) {
            float x = step::prolongate(from.x.data(), {coarse, fine, true}, column, row, 2 * kExtent),
                  y = step::prolongate(from.y.data(), {coarse, fine, true}, column, row, 2 * kExtent);
            step::pin_to_border({fine, {}, 2 * kExtent, 2 * kExtent}, column, row, x, y);
            to.x.push_back(x);
            to.y.push_back(y);
        }
    const step::LatticeView after{fine.columns, fine.rows, to.x.data(), to.y.data()};
    for (int row = 0; row < fine.rows; ++row)
        for (int column = 0; column < fine.columns; ++column)
            EXPECT_FALSE(step::folded(after, column, row)) << column << ' ' << row;
}

}  // namespace
}  // namespace hexrelief::som
