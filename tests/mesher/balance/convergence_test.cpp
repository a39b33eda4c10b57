// Tests balancing's convergence: thin triangles, the threshold derived from them, and the end of a level;
// and rows of edges.
#include "mesher/balance/convergence_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "mesher/balance/edge_integrals_simd.h"
#include "mesher/balance/plan.h"
#include "mesher/balance/triangle_distortion_step.h"
#include "tests/mesher/densities.h"

namespace hexrelief::balance {
namespace {

using namespace testing_mesher;

double least_angle_deg(const float* x, const float* y, const int (&t)[3]) {
    double least = 180;
    for (int k = 0; k < 3; ++k) {
        const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
        const double ux = x[b] - x[a], uy = y[b] - y[a], wx = x[c] - x[a], wy = y[c] - y[a];
        least = std::min(least, std::abs(std::atan2(ux * wy - uy * wx, ux * wx + uy * wy)) * 57.29577951);
    }
    return least;
}

TEST(Thin, TrianglesBelowTheLeastAngle) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> at(0, 30);
    float x[3], y[3];
    int thin = 0;
    for (int k = 0; k < 20000; ++k) {
        for (int i = 0; i < 3; ++i) x[i] = at(random), y[i] = at(random) * (k % 2 ? 1.0f : 0.1f);
        const double angle = least_angle_deg(x, y, {0, 1, 2});
        if (std::abs(angle - 8) < 0.01) continue;
        const double sine = std::sin(8 / 57.29577951);
        const auto square = [&](int i, int j) {
            return (x[j] - x[i]) * (x[j] - x[i]) + (y[j] - y[i]) * (y[j] - y[i]);
        };
        const float area2 = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
        EXPECT_EQ(
            step::is_thin(area2, square(0, 1), square(1, 2), square(2, 0), static_cast<float>(sine * sine)),
            angle < 8)
            << angle;
        thin += angle < 8;
    }
    EXPECT_GT(thin, 2000);
}

// Each triangle of a lattice counts at its three vertices, in both versions of the step.
TEST(Thin, EachTriangleCountsAtItsVertices) {
    constexpr int kColumns = 13, kRows = 9, kCount = kColumns * kRows;
    std::vector<float> x, y, out(7 * kCount);
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) {
            x.push_back(static_cast<float>(column) + 0.5f * static_cast<float>(row & 1));
            y.push_back(static_cast<float>(row));
        }
    step::BalanceView view{};
    view.lattice = {kColumns, kRows};
    view.x = x.data();
    view.y = y.data();
    float* at = out.data();
    for (float** array :
         {&view.inverse_xx, &view.inverse_xy, &view.inverse_yy, &view.reach, &view.step_x, &view.step_y})
        *array = at, at += kCount;
    for (const auto& [sine2, thin] : {std::pair{2.0f, true}, {0.01f, false}}) {
        int all = 0;
        for (int row = 0; row < kRows; ++row)
            for (int column = 0; column < kColumns; ++column) {
                const int here = step::shape_of(view, column, row, {1, sine2});
                all += here;
                if (column > 0 && column + 1 < kColumns && row > 0 && row + 1 < kRows) {
                    EXPECT_EQ(here, thin ? 6 : 0);
                    EXPECT_EQ(step::shape_inner(view, row * kColumns + column, {1, sine2},
                                                step::vertex_ring(kColumns, row)),
                              here);
                }
            }
        EXPECT_EQ(all, thin ? 3 * 2 * (kColumns - 1) * (kRows - 1) : 0);
    }
}

TEST(Threshold, FollowsTheShareOfThinTriangles) {
    BalanceConfig config{.least_angle_deg = 10};
    som::LevelPlan plan;
    plan.lattice = {101, 51};  // 10,000 triangles, at three vertices each
    const step::BalanceView view = balance_view(plan, config, true);
    EXPECT_NEAR(view.thin_sine2, std::pow(std::sin(10 / 57.29577951), 2), 1e-6);
    EXPECT_LT(view.least_threshold, view.threshold);
    EXPECT_GT(view.most_threshold, view.threshold);
    for (const bool late : {false, true}) {
        EXPECT_LT(step::next_threshold(view, 3 * 99, late, view.threshold), view.threshold);
        EXPECT_GT(step::next_threshold(view, 3 * 50, late, view.threshold), view.threshold);
        float threshold = view.threshold;
        for (int k = 0; k < 50; ++k) threshold = step::next_threshold(view, 5000, late, threshold);
        EXPECT_EQ(threshold, view.least_threshold);
        for (int k = 0; k < 50; ++k) threshold = step::next_threshold(view, 0, late, threshold);
        EXPECT_EQ(threshold, view.most_threshold);
    }
    EXPECT_GT(step::next_threshold(view, 3 * 98, false, view.threshold), view.threshold);
    EXPECT_EQ(step::next_threshold(view, 3 * 98, true, view.threshold), view.threshold) << "enough of them";
    EXPECT_TRUE(step::has_thin(view, 3 * 99, step::kThinShare));
    EXPECT_FALSE(step::has_thin(view, 3 * 98, step::kThinShare));
}

// Returns how strongly a triangle with its base on the x axis resists being made higher (> 0) or lower (< 0),
// relative to its height.
double resistance(const step::ShapeLimits& limits, double apex_x, double height, double base) {
    step::ShapeSums sums;
    step::add_triangle(limits, {static_cast<float>(apex_x), static_cast<float>(height)}, {0, 0},
                       {static_cast<float>(base), 0}, sums);
    return sums.gy * height;
}

// The penalty depends on the angle, not on the distortion.
TEST(Penalty, DependsOnTheSmallestAngle) {
    const double degree = 1 / 57.29577951, threshold = 1 / (std::sqrt(3.0) * std::sin(8 * degree));
    for (const double power : {12.0, 24.0}) {
        const step::ShapeLimits limits{static_cast<float>(1 / threshold), 0.02f, power == 24 ? 1.0f : 0.0f};
        const double needle = resistance(limits, 10 * std::tan(4 * degree), 10, 20 * std::tan(4 * degree));
        EXPECT_NEAR(needle, power + 0.03 * threshold, 0.04 * power);
        // flat, with two angles of 8 degrees: E is 1.5 times the sliver's, the penalty the same
        const double flat = resistance(limits, 1, std::tan(8 * degree), 2);
        EXPECT_NEAR(flat, -1.5 * (1.5 * power + 0.03 * threshold), 0.1 * power);
        // flat, with the sliver's E: the angles are 12 degrees, and there is no penalty yet
        EXPECT_NEAR(resistance(limits, 1, std::tan(12 * degree), 2), 0, 0.03 * power);
    }
}

// Returns the iterations of a level whose deviation is `of(t)` and whose triangles are in
// shape from `in_shape_from` on.
template <typename Deviation>
int iterations(const step::BalanceLimits& limits, const Deviation& of, int in_shape_from = 0) {
    float before = 1e30f;
    for (int t = 1; t < limits.most; ++t)
        if (step::is_done(limits, t, static_cast<float>(2 * of(t - 1)), 2, t - 1 >= in_shape_from, before))
            return t;
    return limits.most;
}

TEST(Progress, LevelsEndWhereBalancedOrStuckAndGoOnWhereFar) {
    BalanceConfig config{.iterations = 24};
    const step::BalanceLimits finest = balance_limits(config, 0), next = balance_limits(config, 1),
                              coarse = balance_limits(config, 2);
    EXPECT_EQ(finest.planned, 24);
    EXPECT_EQ(finest.most, 192);
    EXPECT_EQ(next.most, 192);
    EXPECT_EQ(coarse.planned, 48);
    EXPECT_EQ(coarse.most, 384);
    // below 0.5 % from t = 12 on, below 1 % from 10 on
    const auto falls = [](int t) { return 0.3 * std::pow(0.7, t); };
    EXPECT_EQ(iterations(finest, falls), 16);
    EXPECT_EQ(iterations(next, falls), 12);
    const auto stays_near = [](int) { return 0.025; };
    EXPECT_EQ(iterations(finest, stays_near), 24);
    EXPECT_EQ(iterations(next, stays_near), 8);
    const auto stays_far = [](int) { return 0.2; };
    EXPECT_EQ(iterations(next, stays_far), 192);
    EXPECT_EQ(iterations(coarse, stays_far), 384);
    const auto comes_slowly = [](int t) { return 0.8 - 0.01 * t; };  // below 3 % from t = 78 on
    EXPECT_EQ(iterations(coarse, comes_slowly), 79);
    EXPECT_EQ(iterations(coarse, [](int) { return 0.0; }), 4);
    // only the finest level gets stuck late, and it waits for its triangles
    EXPECT_EQ(iterations(finest, stays_far), 44);
    EXPECT_EQ(iterations(finest, comes_slowly), 79);
    EXPECT_EQ(iterations(finest, stays_near, 30), 31);
    EXPECT_EQ(iterations(finest, stays_far, 50), 64);
    EXPECT_EQ(iterations(next, stays_near, 30), 8);
}

TEST(Progress, EmptyLevelsAreDone) {
    float before = 1e30f;
    EXPECT_TRUE(step::is_done({48, 48, 0.01f, 0.9f, false}, 4, 0.5f, 0, false, before));
}

// Compares rows of edges in SIMD batches with single edges: short, long, along the axes and on the border.
TEST(EdgeRows, SameBitsAsSingleEdges) {
    constexpr int kColumns = 23, kRows = 17, kWidth = 140, kHeight = 110;
    const DensityMap density = noise_density(kWidth, kHeight, 8);
    std::vector<double> primitive;
    for (int y = 0; y < kHeight; ++y) {
        primitive.push_back(0);
        for (int x = 0; x < kWidth; ++x) primitive.push_back(primitive.back() + density.at(x, y));
    }
    std::mt19937 random(4);
    for (const float reach : {0.0f, 3.0f, 12.0f, 60.0f}) {
        std::uniform_real_distribution<float> off(-reach, reach);
        std::vector<float> x, y;
        for (int row = 0; row < kRows; ++row)
            for (int column = 0; column < kColumns; ++column) {
                const float shift = 0.5f * static_cast<float>(row & 1);
                x.push_back(std::clamp(6.0f * (static_cast<float>(column) + shift) + off(random), 0.0f,
                                       static_cast<float>(kWidth)));
                y.push_back(std::clamp(6.5f * static_cast<float>(row) + off(random), 0.0f,
                                       static_cast<float>(kHeight)));
            }
        step::BalanceView view{};
        view.lattice = {kColumns, kRows};
        view.slots = (kColumns + 2) / 3;
        view.width = kWidth;
        view.height = kHeight;
        view.primitive = primitive.data();
        view.unit = 0.3;
        view.x = x.data();
        view.y = y.data();
        std::vector<step::EdgeMass> edges(3 * view.slots * kRows);
        view.edges = edges.data();
        int checked = 0;
        for (int row = 0; row < kRows; ++row) {
            measure_boundary_edges(view, row);
            for (int column = 0; column < kColumns; ++column) {
                if (step::honeycomb_class(column, row) != 1) continue;
                for (int j = 0; j < 3; ++j, ++checked) {
                    const step::Neighbour to = step::neighbour_of(view, column, row, 2 * j);
                    const step::EdgeMass is = edges[3 * step::boundary_slot(view, column, row) + j];
                    const step::EdgeMass should =
                        to.exists ? step::edge_mass(view, row * kColumns + column, to.index)
                                  : step::EdgeMass{0, 0, 0};
                    EXPECT_EQ(is.flux, should.flux) << column << " " << row << " " << j;
                    EXPECT_EQ(is.mass, should.mass) << column << " " << row << " " << j;
                    EXPECT_EQ(is.moment, should.moment) << column << " " << row << " " << j;
                }
            }
        }
        EXPECT_GT(checked, 350);
    }
}

}  // namespace
}  // namespace hexrelief::balance
