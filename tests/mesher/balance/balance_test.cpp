// Tests balanced meshes: equal honeycomb weights without a folded triangle. Another test checks
// measure_quality() against its definition.
#include "mesher/balance/balance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesher/balance/cell_equations_step.h"
#include "mesher/balance/plan.h"
#include "mesher/quality/quality.h"
#include "tests/mesher/densities.h"

namespace hexrelief::balance {
namespace {

using namespace testing_mesher;

MeshConfig balanced(bool enabled = true) {
    return {.balance = {.enabled = enabled}};
}

void expect_inside(const HexMesh2D& mesh, const DensityMap& density, const std::string& what) {
    for (const Vec2f& p : mesh.positions) {
        ASSERT_TRUE(p.x >= 0 && p.x <= static_cast<float>(density.width)) << what;
        ASSERT_TRUE(p.y >= 0 && p.y <= static_cast<float>(density.height)) << what;
    }
}

DensityMap map_of(int width, int height, double (*value)(double, double)) {
    DensityMap density = flat_density(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            density.values[static_cast<std::size_t>(y) * width + x] =
                static_cast<float>(value((x + 0.5) / width, (y + 0.5) / height));
    return density;
}

double disc(double u, double v) {
    return std::hypot(u - 0.45, v - 0.5) < 0.2 ? 1.0 : 0.05;
}

TEST(Balance, WeightsOfBumpsBecomeEqual) {
    const DensityMap density = map_of(240, 200, disc);
    const quality::MeshQuality before = quality::measure_quality(solve(density, balanced(false)), density, 1);
    const quality::MeshQuality after = quality::measure_quality(solve(density, balanced()), density, 1);
    EXPECT_GT(before.percent_cost, 10);
    EXPECT_LT(after.percent_cost, 8);
    EXPECT_EQ(after.inverted_triangles, 0);
    EXPECT_GT(after.min_angle_deg, 4);
}

TEST(Balance, FlatAndNoisyDensitiesStayRegular) {
    for (const DensityMap& density : {flat_density(240, 180), map_of(240, 180, [](double u, double v) {
                                          return 1 + 0.5 * std::sin(190 * u) * std::sin(230 * v);
                                      })}) {
        const quality::MeshQuality quality = quality::measure_quality(solve(density, balanced()), density, 1);
        EXPECT_LT(quality.percent_cost, 0.5);
        EXPECT_GT(quality.min_angle_deg, 30);
    }
}

TEST(Balance, SameBytesForAnyNumberOfThreads) {
    const DensityMap density = bumps_density(330, 280);
    MeshConfig config = balanced();
    config.spacing_px = 2;  // the finest lattice is shared among threads, the coarser ones are not
    config.balance.iterations = 3;
    const HexMesh2D one = solve(density, config, 1);
    ASSERT_GE(one.positions.size(), kLeastSharedVertices);
    for (const int threads : {2, 3, 5, 8})
        EXPECT_EQ(solve(density, config, threads).positions, one.positions);
}

TEST(Balance, NoDensityFoldsATriangle) {
    const std::vector<NamedDensity> densities = {
        {"disc on nothing",
         map_of(160, 140, [](double u, double v) { return disc(u, v) > 0.5 ? 1.0 : 0.0; })},
        {"step", map_of(160, 140, [](double u, double) { return u < 0.5 ? 1.0 : 0.02; })},
        {"half empty", map_of(160, 140, [](double u, double) { return u < 0.5 ? 1.0 : 0.0; })},
        {"three decades", map_of(160, 140, [](double u, double) { return std::pow(10, -3 * u); })},
        {"nine tenths empty", map_of(160, 140, [](double u, double v) { return u * v > 0.67 ? 1.0 : 0.0; })},
        {"stripes", map_of(160, 140, [](double u, double) { return std::fmod(u, 0.1) < 0.02 ? 1.0 : 0.0; })},
        {"bright pixel", bright_pixel_density(160, 140, 31, 77)},
        {"noise", noise_density(160, 140, 7)},
        {"empty", flat_density(160, 140, 0)},
        {"faint", flat_density(160, 140, 1e-30f)},
        {"ramp", ramp_density(160, 140)},
    };
    for (const MeshBorder border : {MeshBorder::slide, MeshBorder::free})
        for (const double spacing : {2.0, 6.0, 13.0})
            for (const NamedDensity& each : densities) {
                MeshConfig config = balanced();
                config.border = border;
                config.spacing_px = spacing;
                config.balance.iterations = spacing == 2.0 ? 3 : 20;
                const std::string what = each.name + ", " + describe(each.density, config);
                const HexMesh2D mesh = solve(each.density, config);
                expect_inside(mesh, each.density, what);
                EXPECT_EQ(quality::measure_quality(mesh, each.density, 1).inverted_triangles, 0) << what;
            }
}

TEST(Balance, SmallestAndThinnestLattices) {
    for (const auto& [width, height] : {std::pair{18, 18}, {19, 60}, {200, 18}, {31, 30}}) {
        const DensityMap density = ramp_density(width, height);
        const HexMesh2D mesh = solve(density, balanced());
        expect_inside(mesh, density, "");
        EXPECT_EQ(quality::measure_quality(mesh, density, 1).inverted_triangles, 0) << width << "x" << height;
    }
}

TEST(Balance, LeastAngleTradesBalanceForShape) {
    const DensityMap density =
        map_of(240, 200, [](double u, double v) { return disc(u, v) > 0.5 ? 1.0 : 0.0; });
    MeshConfig slender = balanced(), stout = balanced();
    slender.border = stout.border =
        MeshBorder::slide;  // on a disc with nothing around it balance and shape do not conflict
    slender.balance.least_angle_deg = 3;
    stout.balance.least_angle_deg = 14;
    const quality::MeshQuality a = quality::measure_quality(solve(density, slender), density, 1);
    const quality::MeshQuality b = quality::measure_quality(solve(density, stout), density, 1);
    EXPECT_LT(a.percent_cost, 0.7 * b.percent_cost);
    EXPECT_LT(a.percentile1_angle_deg, 0.7 * b.percentile1_angle_deg);
}

TEST(Balance, OffLeavesTheTrainedMapAlone) {
    const DensityMap density = bumps_density(160, 140);
    MeshConfig other = balanced(false);
    other.balance.iterations = 1;
    EXPECT_EQ(solve(density, balanced(false)).positions, solve(density, other).positions);
    EXPECT_NE(solve(density, balanced(false)).positions, solve(density, balanced()).positions);
}

TEST(BalancePlan, SweepsShrinkEveryEigenvector) {
    const std::vector<SweepGain> gains = chebyshev_gains(24);
    ASSERT_EQ(gains.size(), 24u);
    for (double eigenvalue = 0.02; eigenvalue <= 1; eigenvalue += 0.02) {
        double x = 0, direction = 0;
        for (const SweepGain& g : gains) {
            direction = g.keep * direction + g.gain * (1 - eigenvalue * x);
            x += direction;
        }
        EXPECT_NEAR(eigenvalue * x, 1, 0.01) << eigenvalue;
    }
}

TEST(BalancePlan, DistortionIsOneForTheEquilateralAndGrowsWhenThinner) {
    EXPECT_NEAR(distortion_of_angle(60), 1, 1e-12);
    EXPECT_NEAR(distortion_of_angle(8), 4.19, 0.01);
    EXPECT_GT(distortion_of_angle(4), 2 * distortion_of_angle(9));
}

TEST(BalancePlan, CoarserLevelsIterateMore) {
    BalanceConfig config{.iterations = 20};
    EXPECT_EQ(balance_iterations(config, 0), 20);
    EXPECT_EQ(balance_iterations(config, 1), 20);
    EXPECT_EQ(balance_iterations(config, 2), 40);
    EXPECT_EQ(balance_iterations(config, 3), 40);
    EXPECT_EQ(balance_iterations(config, 12), 40);
}

TEST(BalanceSteps, EdgeMassOfADiagonalByHand) {
    // density 1 and 3 in two pixels side by side, 5 and 7 below
    const std::vector<double> primitive = {0, 1, 4, 0, 5, 12};
    std::vector<float> x = {0.5f, 1.5f}, y = {0.25f, 1.75f};
    step::BalanceView view{};
    view.width = view.height = 2;
    view.primitive = primitive.data();
    view.unit = 1;
    view.x = x.data();
    view.y = y.data();
    // through (1, 1): half of the edge lies in the pixel of density 1, half in the pixel of density 7
    const step::EdgeMass there = step::edge_mass(view, 0, 1), back = step::edge_mass(view, 1, 0);
    EXPECT_NEAR(there.mass, 0.5 * 1 + 0.5 * 7, 1e-6);
    EXPECT_NEAR(there.moment, 0.125 * 1 + 0.375 * 7, 1e-6);
    // P dy: the mean of P is 0.75 over the upper half and 5 + 7 x 0.25 over the lower half
    EXPECT_NEAR(there.flux, 0.75 * 0.75 + 0.75 * (5 + 7 * 0.25), 1e-6);
    EXPECT_NEAR(back.flux, -there.flux, 1e-9);
    EXPECT_NEAR(back.moment, there.mass - there.moment, 1e-6);
}

// Compares a long edge through noise, in both directions, steep and flat, with a sum
// over many short segments.
TEST(BalanceSteps, EdgeMassOfLongEdges) {
    constexpr int kWidth = 61, kHeight = 47, kPieces = 2000000;
    const DensityMap density = noise_density(kWidth, kHeight, 3);
    std::vector<double> primitive;
    for (int y = 0; y < kHeight; ++y) {
        primitive.push_back(0);
        for (int x = 0; x < kWidth; ++x) primitive.push_back(primitive.back() + density.at(x, y));
    }
    std::vector<float> x = {1.25f, 58.5f, 3.5f, 61, 0, 20, 20}, y = {44.75f, 2.25f, 0, 45.5f, 47, 3, 40};
    step::BalanceView view{};
    view.width = kWidth;
    view.height = kHeight;
    view.primitive = primitive.data();
    view.unit = 1;
    view.x = x.data();
    view.y = y.data();
    for (const auto& [from, to] : {std::pair{0, 1}, {1, 0}, {2, 3}, {3, 4}, {5, 6}, {6, 5}, {2, 4}}) {
        double mass = 0, moment = 0, flux = 0;
        const double dx = x[to] - x[from], dy = y[to] - y[from];
        for (int k = 0; k < kPieces; ++k) {
            const double t = (k + 0.5) / kPieces, px = x[from] + t * dx;
            const int column = std::min(static_cast<int>(px), kWidth - 1),
                      row = std::min(static_cast<int>(y[from] + t * dy), kHeight - 1);
            const double* const p = &primitive[row * (kWidth + 1) + column];
            mass += (p[1] - p[0]) / kPieces;
            moment += t * (p[1] - p[0]) / kPieces;
            flux += (p[0] + (px - column) * (p[1] - p[0])) * dy / kPieces;
        }
        const step::EdgeMass edge = step::edge_mass(view, from, to);
        EXPECT_NEAR(edge.mass, mass, 1e-4) << from << " " << to;
        EXPECT_NEAR(edge.moment, moment, 1e-4) << from << " " << to;
        EXPECT_NEAR(edge.flux, flux, 1e-3) << from << " " << to;
    }
}

TEST(BalanceSteps, RingOfACellNamesItsSixNeighbours) {
    step::BalanceView view{};
    view.lattice = {31, 29};
    view.slots = (31 + 2) / 3;
    view.stride = view.slots + 2;
    int checked = 0;
    for (int row = 2; row < 27; ++row)
        for (int column = 3; column < 28; ++column) {
            if (step::honeycomb_class(column, row) != 0) continue;
            const step::CellRing ring = step::cell_ring(view, row);
            for (int k = 0; k < 6; ++k, ++checked) {
                // beyond boundary edge k, k + 1: one lattice step in direction k, then one in direction k + 1
                const step::Offset a = step::neighbour_offset(row, k);
                const step::Offset b = step::neighbour_offset(row + a.row, (k + 1) % 6);
                const int c = column + a.column + b.column, r = row + a.row + b.row;
                EXPECT_EQ(step::honeycomb_class(c, r), 0);
                EXPECT_EQ(step::cell_slot(view, column, row) + ring.at[k], step::cell_slot(view, c, r));
            }
        }
    EXPECT_GT(checked, 1000);
}

}  // namespace
}  // namespace hexrelief::balance
