#include "mesher/quality/quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/mesher/densities.h"
#include "tests/mesher/naive_quality.h"

namespace hexrelief::quality {
namespace {

using namespace testing_mesher;

// Returns the regular lattice of the image with every vertex moved by up to `jitter_px`, within the image.
HexMesh2D jittered(const DensityMap& density, double spacing_px, double jitter_px, std::uint32_t seed) {
    HexMesh2D mesh = mesher::regular_lattice(density.width, density.height, spacing_px);
    std::mt19937 random(seed);
    const auto offset = [&] { return jitter_px * (2.0 * (random() >> 8) / (1 << 24) - 1); };
    for (Vec2f& p : mesh.positions) {
        p.x = static_cast<float>(std::clamp(p.x + offset(), 0.0, static_cast<double>(density.width)));
        p.y = static_cast<float>(std::clamp(p.y + offset(), 0.0, static_cast<double>(density.height)));
    }
    return mesh;
}

// Returns a percentile: the value with `percent` hundredths of all values, rounded down, below it.
double sorted_at(std::vector<double> values, std::size_t percent) {
    std::sort(values.begin(), values.end());
    return values.at(values.size() * percent / 100);
}

void expect_agreement(const HexMesh2D& mesh, const DensityMap& density) {
    const NaiveQuality naive = naive_quality(mesh, density);
    const MeshQuality quality = measure_quality(mesh, density, 2);
    const std::vector<double> weights = honeycomb_weights(mesh, density, 2);
    ASSERT_EQ(weights.size(), naive.weights.size());
    EXPECT_EQ(quality.honeycomb_cells, static_cast<int>(naive.weights.size()));
    for (std::size_t k = 0; k < weights.size(); ++k)
        EXPECT_NEAR(weights[k], naive.weights[k], 1e-6) << "cell " << k;
    EXPECT_NEAR(quality.percent_cost, naive.percent_cost, 1e-6);
    EXPECT_NEAR(quality.max_deviation_percent, naive.max_deviation_percent, 1e-6);
    EXPECT_EQ(quality.inverted_triangles, naive.inverted);
    EXPECT_NEAR(quality.min_angle_deg, naive.min_angle_deg, 1e-4);
    EXPECT_NEAR(quality.percentile1_angle_deg, sorted_at(naive.angles_deg, 1), 1e-4);
    EXPECT_NEAR(quality.median_angle_deg, sorted_at(naive.angles_deg, 50), 1e-4);
    double mean = 0;
    for (const double w : naive.weights) mean += w / static_cast<double>(naive.weights.size());
    EXPECT_NEAR(quality.percentile5_weight_percent, 100 * sorted_at(naive.weights, 5) / mean, 1e-4);
    EXPECT_NEAR(quality.percentile50_weight_percent, 100 * sorted_at(naive.weights, 50) / mean, 1e-4);
    EXPECT_NEAR(quality.percentile95_weight_percent, 100 * sorted_at(naive.weights, 95) / mean, 1e-4);
}

class QualityOracle : public testing::TestWithParam<int> {};

TEST_P(QualityOracle, RandomMeshesIncludingFoldedOnes) {
    const int seed = GetParam();
    const DensityMap density = noise_density(37 + seed % 5, 31 + seed % 7, static_cast<std::uint32_t>(seed));
    const HexMesh2D mesh = jittered(density, 5, seed % 4 * 2.5, static_cast<std::uint32_t>(seed));
    if (seed % 4 == 3) {
        EXPECT_GT(naive_quality(mesh, density).inverted, 0) << "this case is meant to have folded triangles";
    }
    expect_agreement(mesh, density);
}

INSTANTIATE_TEST_SUITE_P(Seeds, QualityOracle, testing::Range(0, 12));

TEST(Quality, VerticesOnPixelCornersAndTheImageBorder) {
    const DensityMap density = bumps_density(24, 24);
    HexMesh2D mesh = mesher::regular_lattice(24, 24, 4);
    for (Vec2f& p : mesh.positions) p = {std::round(p.x), std::round(p.y)};
    for (int row = 0; row < mesh.rows; ++row) {
        mesh.positions[mesh.index(0, row)].x = 0;
        mesh.positions[mesh.index(mesh.columns - 1, row)].x = 24;
    }
    expect_agreement(mesh, density);
}

TEST(Quality, CollapsedLatticeIsAllInvertedAndFree) {
    const DensityMap density = flat_density(30, 30);
    HexMesh2D mesh = mesher::regular_lattice(30, 30, 5);
    for (Vec2f& p : mesh.positions) p = {7.5f, 8.25f};
    const MeshQuality quality = measure_quality(mesh, density, 1);
    EXPECT_EQ(quality.inverted_triangles, static_cast<long long>(mesh.triangle_count()));
    EXPECT_EQ(quality.percent_cost, 0);
}

TEST(Quality, RegularLatticeOnFlatDensityCostsNothing) {
    const DensityMap density = flat_density(120, 104);
    const MeshQuality quality = measure_quality(mesher::regular_lattice(120, 104, 6), density, 1);
    EXPECT_LT(quality.percent_cost, 1e-3);
    EXPECT_GT(quality.honeycomb_cells, 80);
    EXPECT_EQ(quality.inverted_triangles, 0);
    EXPECT_GT(quality.min_angle_deg, 45);
}

TEST(Quality, MirroredLatticeIsAllInverted) {
    const DensityMap density = flat_density(60, 60);
    HexMesh2D mesh = mesher::regular_lattice(60, 60, 6);
    const double before = measure_quality(mesh, density, 1).percent_cost;
    for (Vec2f& p : mesh.positions) p.x = 60 - p.x;
    const MeshQuality quality = measure_quality(mesh, density, 1);
    EXPECT_EQ(quality.inverted_triangles, static_cast<long long>(mesh.triangle_count()));
    EXPECT_NEAR(quality.percent_cost, before, 1e-3);
}

TEST(Quality, ScaleOfTheDensityDoesNotMatter) {
    const DensityMap density = bumps_density(60, 48);
    DensityMap scaled = density;
    for (float& v : scaled.values) v *= 1024;
    const HexMesh2D mesh = jittered(density, 6, 1, 5);
    EXPECT_NEAR(measure_quality(mesh, density, 1).percent_cost, measure_quality(mesh, scaled, 1).percent_cost,
                1e-9);
}

TEST(Quality, NoDensityAndNoCellCostNothing) {
    EXPECT_EQ(measure_quality(mesher::regular_lattice(40, 40, 5), flat_density(40, 40, 0), 1).percent_cost,
              0);
    HexMesh2D none;
    EXPECT_EQ(measure_quality(none, flat_density(4, 4), 1).honeycomb_cells, 0);
}

}  // namespace
}  // namespace hexrelief::quality
