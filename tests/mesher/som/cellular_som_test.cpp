// Tests what must hold for every mesh, whatever the density and the configuration: oriented,
// inside the image, unfolded.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mesher/quality/quality.h"
#include "mesher/som/cellular_som.h"
#include "mesher/som/level_plan.h"
#include "tests/expect_error.h"
#include "tests/mesher/densities.h"

namespace hexrelief::som {
namespace {

using namespace testing_mesher;

void expect_sound(const DensityMap& density, const MeshConfig& config, const HexMesh2D& mesh) {
    ASSERT_EQ(mesh.positions.size(), static_cast<std::size_t>(mesh.columns) * mesh.rows);
    for (const Vec2f& p : mesh.positions) {
        ASSERT_TRUE(p.x >= 0 && p.x <= static_cast<float>(density.width))
            << p.x << "; " << describe(density, config);
        ASSERT_TRUE(p.y >= 0 && p.y <= static_cast<float>(density.height))
            << p.y << "; " << describe(density, config);
    }
    EXPECT_EQ(quality::measure_quality(mesh, density, 1).inverted_triangles, 0) << describe(density, config);
}

void expect_sound(const DensityMap& density, const MeshConfig& config) {
    expect_sound(density, config, solve(density, config));
}

TEST(Shape, NeverMirroredAtAnySizeLevelsOrRadius) {
    MeshConfig config{.t_max = 30};
    for (const int width : {18, 31, 47, 72, 100, 150})
        for (const int height : {18, 40, 73, 145})
            for (const int levels : {0, 1, 2, 3, 4, 5, 6})
                for (const double sigma : {6.0, 100.0}) {
                    if (levels > 2 && std::min(width, height) < 145) continue;  // the same as 2 levels there
                    config.levels = levels;
                    config.sigma_init = sigma;
                    config.sigma_level_init = sigma;
                    expect_sound(bumps_density(width, height), config);
                }
}

// The paper's border shrinks inwards, but the lattice must not turn over.
TEST(Shape, FreeBorderIsNeverMirrored) {
    MeshConfig config{.t_max = 60, .border = MeshBorder::free};
    for (const int size : {18, 31, 47, 72, 150})
        for (const double sigma : {6.0, 12.0, 100.0})
            for (const int levels : {1, 3}) {
                config.sigma_init = sigma;
                config.levels = levels;
                expect_sound(bumps_density(size, size + 7), config);
            }
}

TEST(Shape, RandomConfigurationsWithTheSlidingBorder) {
    std::mt19937 random(2026);
    const auto pick = [&](double from, double to) {
        return from + (to - from) * (random() >> 8) / (1 << 24);
    };
    for (int round = 0; round < 100; ++round) {
        MeshConfig config{.spacing_px = pick(2, 9),
                          .levels = static_cast<int>(random() % 5),
                          .t_max = 1 + static_cast<int>(random() % 40),
                          .alpha_init = pick(0.2, 1),
                          .alpha_final = pick(0.001, 0.2),
                          .sigma_init = pick(1, 20),
                          .sigma_level_init = pick(1, 8),
                          .sigma_level_final = pick(0.5, 3),
                          .sigma_final = pick(0.3, 2),
                          .co = 1 + static_cast<int>(random() % 30),
                          .delta = pick(0.1, 8),
                          .ssr = static_cast<int>(random() % 5),
                          .crr = 1 + static_cast<int>(random() % 30),
                          .prr = 1 + static_cast<int>(random() % 16),
                          .prr_final = static_cast<int>(random() % 33),
                          .magnification = pick(0.5, 2),
                          .seed = random()};
        const int least = static_cast<int>(std::ceil(3 * config.spacing_px));
        const int width = least + static_cast<int>(random() % 110),
                  height = least + static_cast<int>(random() % 90);
        const DensityMap densities[] = {
            bumps_density(width, height), noise_density(width, height, static_cast<std::uint32_t>(round)),
            ramp_density(width, height), bright_pixel_density(width, height, width / 3, height / 4)};
        expect_sound(densities[round % 4], config);
    }
}

// All density is in one place: the mesh must still cover the image unfolded.
TEST(Shape, OneBrightPixel) {
    MeshConfig config;
    for (const int x : {0, 40, 99}) {
        const DensityMap density = bright_pixel_density(100, 80, x, 79 - x / 2);
        const HexMesh2D mesh = solve(density, config);
        expect_sound(density, config, mesh);
        double nearest = 1e9;
        for (const Vec2f& p : mesh.positions)
            nearest = std::min(nearest, std::hypot(p.x - x - 0.5, p.y - (79 - x / 2) - 0.5));
        EXPECT_LT(nearest, 1) << "some vertex must have gone to the pixel";
    }
}

TEST(Shape, SmallestLatticeAndThinImages) {
    for (const auto& [width, height] : {std::pair{18, 18}, {200, 18}, {18, 200}, {19, 201}, {1001, 21}}) {
        MeshConfig config{.t_max = 40};
        for (const MeshBorder border : {MeshBorder::slide, MeshBorder::free}) {
            config.border = border;
            const DensityMap density = bumps_density(width, height);
            const HexMesh2D mesh = solve(density, config);
            EXPECT_EQ(mesh.columns, std::lround(width / 6.0));
            EXPECT_EQ(mesh.rows, std::max(3L, std::lround(height / 6.0)));
            expect_sound(density, config, mesh);
        }
    }
}

TEST(Shape, TooSmallAnImageIsAUsageError) {
    MeshConfig config;
    for (const DensityMap& small : {flat_density(17, 100), flat_density(100, 17), flat_density(1, 1)})
        EXPECT_CONTAINS(test::error_of([&] { solve(small, config); }, ErrorKind::usage), "mesh.spacing_px")
            << small.width << "x" << small.height << " px";
}

TEST(Shape, NoDensityGivesTheRegularLattice) {
    MeshConfig config{.border = MeshBorder::free};
    const DensityMap density = flat_density(90, 66, 0);
    for (const MeshMethod method : {MeshMethod::cellular, MeshMethod::sequential}) {
        config.levels = 1;
        config.method = method;
        EXPECT_EQ(solve(density, config).positions,
                  mesher::regular_lattice(90, 66, config.spacing_px).positions);
    }
    // Coarse to fine, the lattice results from prolongation, and the sliding border is pinned.
    config = {};
    const HexMesh2D mesh = solve(flat_density(240, 180, 0), config),
                    regular = mesher::regular_lattice(240, 180, config.spacing_px);
    for (int row = 1; row + 1 < mesh.rows; ++row)
        for (int column = 1; column + 1 < mesh.columns; ++column) {
            // the pinned border bends its surroundings on the coarsest level, whose spacing is 12 px
            EXPECT_NEAR(mesh.at(column, row).x, regular.at(column, row).x, 7) << column << "," << row;
            EXPECT_NEAR(mesh.at(column, row).y, regular.at(column, row).y, 7) << column << "," << row;
        }
    expect_sound(flat_density(240, 180, 0), config, mesh);
}

// Returns the mean distance, in spacings, from the undeformed lattice.
double drift(const HexMesh2D& mesh, double spacing_px) {
    const HexMesh2D regular = mesher::regular_lattice(240, 180, spacing_px);
    double sum = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        sum += std::hypot(mesh.positions[i].x - regular.positions[i].x,
                          mesh.positions[i].y - regular.positions[i].y);
    return sum / static_cast<double>(mesh.positions.size()) / spacing_px;
}

TEST(Shape, FlatDensityStaysNearlyRegular) {
    MeshConfig config{.t_max = 80, .balance = {.enabled = false}};
    const DensityMap density = flat_density(240, 180);
    const HexMesh2D mesh = solve(density, config);
    EXPECT_LT(drift(mesh, config.spacing_px), 0.25);
    const quality::MeshQuality quality = quality::measure_quality(mesh, density, 1);
    EXPECT_LT(quality.percent_cost, 7);
    EXPECT_GT(quality.percentile1_angle_deg, 30);
}

// Balancing stretches the lattice evenly to the pinned border, which lies half a spacing further out.
TEST(Shape, BalancedFlatDensityIsTheStretchedLattice) {
    const MeshConfig config;
    const DensityMap density = flat_density(240, 180);
    const HexMesh2D mesh = solve(density, config);
    EXPECT_LT(drift(mesh, config.spacing_px), 0.5);
    const quality::MeshQuality quality = quality::measure_quality(mesh, density, 1);
    EXPECT_LT(quality.percent_cost, 0.5);
    EXPECT_GT(quality.percentile1_angle_deg, 35);
}

TEST(Shape, SlidingBorderLiesOnTheImages) {
    MeshConfig config{.t_max = 30, .border = MeshBorder::slide};
    const HexMesh2D mesh = solve(bumps_density(151, 139), config);
    for (int row = 0; row < mesh.rows; ++row) {
        EXPECT_EQ(mesh.at(0, row).x, 0);
        EXPECT_EQ(mesh.at(mesh.columns - 1, row).x, 151);
    }
    for (int column = 0; column < mesh.columns; ++column) {
        EXPECT_EQ(mesh.at(column, 0).y, 0);
        EXPECT_EQ(mesh.at(column, mesh.rows - 1).y, 139);
    }
}

// A lattice crumpled at random unfolds by repair, and a sound one stays as it is.
TEST(Untangle, RepairsCrumpledLatticesAndLeavesSoundOnesAlone) {
    MeshConfig config{.levels = 1};
    for (const auto& [width, height] : {std::pair{60, 54}, {150, 120}, {30, 200}}) {
        const LevelPlan plan = plan_levels(width, height, config, {0, 0, width, height}).front();
        LatticePositions sound = regular_positions(plan);
        pin_border(plan, sound);
        LatticePositions repaired = sound;
        ThreadPool pool(2);
        EXPECT_EQ(untangle(plan, true, nullptr, pool, repaired), 0);
        EXPECT_EQ(repaired.x, sound.x);
        EXPECT_EQ(repaired.y, sound.y);
        std::mt19937 random(static_cast<std::uint32_t>(width));
        for (std::size_t i = 0; i < sound.x.size(); ++i) {
            repaired.x[i] = static_cast<float>(random() % (width + 1));
            repaired.y[i] = static_cast<float>(random() % (height + 1));
        }
        pin_border(plan, repaired);
        EXPECT_GT(untangle(plan, true, nullptr, pool, repaired), 0);
        HexMesh2D mesh{plan.lattice.columns, plan.lattice.rows, {}};
        for (std::size_t i = 0; i < repaired.x.size(); ++i)
            mesh.positions.push_back({repaired.x[i], repaired.y[i]});
        expect_sound(flat_density(width, height), config, mesh);
    }
}

}  // namespace
}  // namespace hexrelief::som
