// Tests the paper's CPU counterpart, the reference for the parallel model's quality.
#include <gtest/gtest.h>

#include "mesher/quality/quality.h"
#include "mesher/som/cellular_som.h"
#include "mesher/som/level_plan.h"
#include "tests/mesher/densities.h"
#include "tests/mesher/naive_som.h"

namespace hexrelief::som {
namespace {

using namespace testing_mesher;

MeshConfig paper_schedule(MeshMethod method, int t_max) {
    MeshConfig config = paper_config(t_max);
    config.method = method;
    return config;
}

// Returns the positions before folded triangles are repaired.
std::vector<Vec2f> trained(const DensityMap& density, const MeshConfig& config) {
    const MeshArea area = mesh_area(density, config);
    const LevelPlan plan = plan_levels(density.width, density.height, config, area).back();
    const LatticePositions positions = train_sequential(density_within(density, area), plan, config, {});
    std::vector<Vec2f> out;
    for (std::size_t i = 0; i < positions.x.size(); ++i)
        out.push_back(
            {static_cast<float>(area.x) + positions.x[i], static_cast<float>(area.y) + positions.y[i]});
    return out;
}

TEST(Sequential, ConvergesOnARamp) {
    const DensityMap density = ramp_density(240, 200);
    const double start =
        quality::measure_quality(mesher::regular_lattice(240, 200, 6), density, 1).percent_cost;
    const auto quality = [&](int t_max) {
        return quality::measure_quality(solve(density, paper_schedule(MeshMethod::sequential, t_max)),
                                        density, 1);
    };
    EXPECT_GT(start, 90);
    const quality::MeshQuality early = quality(100), late = quality(800);
    EXPECT_LT(early.percent_cost, 0.8 * start);
    EXPECT_GT(late.percent_cost, 13);  // 16.3 when measured
    EXPECT_LT(late.percent_cost, 20);
    EXPECT_EQ(late.inverted_triangles, 0);
}

TEST(Sequential, SamePositionsAsPlainLoops) {
    const DensityMap densities[] = {bumps_density(60, 48), noise_density(61, 50, 3),
                                    bright_pixel_density(60, 48, 40, 2)};
    for (const DensityMap& density : densities)
        for (const int co : {7, 20, 100}) {
            MeshConfig config = paper_schedule(MeshMethod::sequential, 45);
            config.co = co;
            config.sigma_init = 5;
            config.seed = static_cast<std::uint64_t>(co) << 33;
            EXPECT_EQ(trained(density, config), naive_sequential(density, config).positions)
                << describe(density, config);
        }
}

// Training without repair leaves some there.
TEST(Sequential, LeavesNoInvertedTriangles) {
    MeshConfig config = paper_schedule(MeshMethod::sequential, 45);
    config.co = 7;
    config.sigma_init = 5;
    const DensityMap density = bright_pixel_density(60, 48, 40, 2);
    HexMesh2D untouched = solve(density, config);
    untouched.positions = trained(density, config);
    EXPECT_GT(quality::measure_quality(untouched, density, 1).inverted_triangles, 0);
    EXPECT_EQ(quality::measure_quality(solve(density, config), density, 1).inverted_triangles, 0);
}

TEST(Sequential, CellularComesNear) {
    const DensityMap density = bumps_density(240, 200);
    const auto cost = [&](MeshMethod method) {
        return quality::measure_quality(solve(density, paper_schedule(method, 500)), density, 1).percent_cost;
    };
    const double sequential = cost(MeshMethod::sequential), cellular = cost(MeshMethod::cellular);
    EXPECT_LT(cellular, sequential + 7);  // 26.8 against 21.6 when measured
}

TEST(Sequential, CountsIterationsAndSeeds) {
    MeshConfig config = paper_schedule(MeshMethod::sequential, 20);
    config.levels = 4;  // the sequential method has one level, whatever is configured
    const DensityMap density = bumps_density(120, 100);
    const HexMesh2D one = mesher::solve_mesh(density, config, 1, {});
    EXPECT_EQ(one.iterations, 20);
    config.seed = 2;
    EXPECT_NE(one.positions, solve(density, config).positions);
}

}  // namespace
}  // namespace hexrelief::som
