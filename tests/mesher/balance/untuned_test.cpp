// Tests the default configuration on made-up maps on which nothing was tuned: balanced,
// well shaped, nothing folded.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mesher/quality/quality.h"
#include "pipeline/stages/density.h"
#include "tests/mesher/densities.h"

namespace hexrelief::balance {
namespace {

constexpr int kWidth = 450, kHeight = 375;

struct Scene {
    std::string name;
    double (*disparity)(double x, double y);
    double most_cost = 8, least_angle_deg = 8;
    bool keeps_background = false;
};

// A step from 60 to 20 px through the image's centre; the nearer half lies opposite
// to the direction `angle_deg`.
double step_at(double x, double y, double angle_deg) {
    const double angle = angle_deg * 0.017453292519943295;
    return (x - 225) * std::cos(angle) + (y - 187.5) * std::sin(angle) < 0 ? 60 : 20;
}

double disc_above(double x, double y, double far) {
    return std::hypot(x - 225, y - 190) < 60 ? 60 : far;
}

void PrintTo(const Scene& scene, std::ostream* out) {
    *out << scene.name;
}

DisparityMap map_of(const Scene& scene) {
    DisparityMap map{kWidth, kHeight, std::vector<float>(static_cast<std::size_t>(kWidth) * kHeight)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            map.values[static_cast<std::size_t>(y) * kWidth + x] = static_cast<float>(scene.disparity(x, y));
    return map;
}

double noise(double x, double y) {
    std::mt19937 random(static_cast<unsigned>(y * kWidth + x));
    return 5 + 55 * (static_cast<double>(random() % 100000) / 100000);
}

class Untuned : public testing::TestWithParam<Scene> {};

TEST_P(Untuned, BalancedAndInShape) {
    const DisparityMap map = map_of(GetParam());
    stages::DensityConfig config;
    config.background_method =
        GetParam().keeps_background ? stages::BackgroundMethod::none : stages::BackgroundMethod::fraction;
    config.floor = 0;
    const DensityMap density = stages::compute_density(map, config);
    for (const int seed : {1, 2}) {
        MeshConfig mesh_config{.seed = static_cast<std::uint64_t>(seed)};
        const HexMesh2D mesh = mesher::solve_mesh(density, mesh_config, 1, {});
        const quality::MeshQuality quality = quality::measure_quality(mesh, density, 1);
        std::printf("%-22s %%cost %5.2f, 1st percentile angle %5.2f deg\n", GetParam().name.c_str(),
                    quality.percent_cost, quality.percentile1_angle_deg);
        EXPECT_LE(quality.percent_cost, GetParam().most_cost);
        EXPECT_GE(quality.percentile1_angle_deg, GetParam().least_angle_deg);
        EXPECT_EQ(quality.inverted_triangles, 0);
        for (const Vec2f& p : mesh.positions)
            ASSERT_TRUE(p.x >= 0 && p.x <= kWidth && p.y >= 0 && p.y <= kHeight);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Maps, Untuned,
    ::testing::Values(
        Scene{"Constant", [](double, double) { return 40.0; }, 0.5, 40}, Scene{"Noise", noise, 1, 39},
        Scene{"DiscOnAPlane", [](double x, double y) { return disc_above(x, y, 25); }},
        Scene{"DiscOnAFarPlane", [](double x, double y) { return disc_above(x, y, 20); }},
        Scene{"DiscAsideOnAFarPlane", [](double x, double y) { return disc_above(x + 105, y + 60, 20); }},
        Scene{"DiscOnBackground", [](double x, double y) { return disc_above(x, y, 10); }},
        Scene{"RectangleOfATenth",
              [](double x, double y) { return x >= 150 && x < 328 && y >= 100 && y < 195 ? 60.0 : 2.0; }},
        Scene{"StepDown", [](double x, double) { return x < 200 ? 60.0 : 20.0; }},
        Scene{"StepUp", [](double x, double) { return x < 250 ? 20.0 : 60.0; }},
        Scene{"StepAcross", [](double, double y) { return y < 170 ? 60.0 : 20.0; }},
        Scene{"StepAt30", [](double x, double y) { return step_at(x, y, 30); }},
        Scene{"StepAt135", [](double x, double y) { return step_at(x, y, 135); }},
        Scene{"StepAt240", [](double x, double y) { return step_at(x, y, 240); }},
        Scene{"StepAt300", [](double x, double y) { return step_at(x, y, 300); }},
        Scene{"Ramp", [](double x, double) { return std::pow(10, x / kWidth + 0.8); }},
        Scene{"RampOfThreeDecades", [](double x, double) { return std::pow(10, x / kWidth + 0.8); }, 8, 8,
              true},
        Scene{"RampOfThreeDecadesDown", [](double, double y) { return std::pow(10, y / kHeight + 0.8); }, 8,
              8, true},
        Scene{"Ring",
              [](double x,
                 double y) { return std::abs(std::hypot(x - 225, y - 190) - 100) < 20 ? 60.0 : 2.0; }}),
    [](const auto& i) { return i.param.name; });

}  // namespace
}  // namespace hexrelief::balance
