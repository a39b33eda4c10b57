// The robust disparity of a mesh vertex.
#include "mesher/som/vertex_disparity_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/data/disparity_map.h"
#include "tests/mesher/densities.h"

namespace hexrelief::testing_mesher {
namespace {

template <typename Value>
DisparityMap make_map(int width, int height, const Value& value) {
    DisparityMap map{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) map.values.push_back(static_cast<float>(value(x + 0.5, y + 0.5)));
    return map;
}

float sample(const DisparityMap& map, float x, float y, float background_px = 0) {
    return step::vertex_disparity({map.width, map.height, map.values.data(), background_px}, x, y,
                                  kUnknownDisparity);
}

constexpr int kWidth = 40, kHeight = 30;

TEST(VertexDisparity, ExactOnSlantedPlanes) {
    std::mt19937 random(4);
    for (const auto& [gx, gy] : {std::pair{0.0, 0.0}, {0.4, 0.0}, {0.0, -0.4}, {0.25, 0.3}, {-0.45, 0.1}}) {
        const auto plane = [&, sx = gx, sy = gy](double x, double y) { return 60 + sx * x + sy * y; };
        const DisparityMap map = make_map(kWidth, kHeight, plane);
        for (int i = 0; i < 300; ++i) {
            const double x = 0.5 + (kWidth - 1) * static_cast<double>(random()) / 4294967296.0;
            const double y = 0.5 + (kHeight - 1) * static_cast<double>(random()) / 4294967296.0;
            ASSERT_NEAR(sample(map, static_cast<float>(x), static_cast<float>(y)), plane(x, y), 1e-4)
                << x << ", " << y;
        }
    }
}

// Between the outermost pixel centres and the border the value stays within those of the pixels around.
TEST(VertexDisparity, BorderVerticesAreNotExtrapolated) {
    const DisparityMap map =
        make_map(kWidth, kHeight, [](double x, double y) { return 60 + 0.4 * x - 0.3 * y; });
    for (const auto& [x, y] : {std::pair{0.f, 0.f}, {40.f, 30.f}, {0.f, 30.f}, {40.f, 0.f}, {40.f, 15.2f}}) {
        const double exact = 60 + 0.4 * x - 0.3 * y;
        EXPECT_NEAR(sample(map, x, y), exact, 0.36);
    }
}

TEST(VertexDisparity, WholePixelMapsAreSmoothed) {
    const auto plane = [](double x, double y) { return 60 + 0.2 * x + 0.1 * y; };
    const DisparityMap map =
        make_map(kWidth, kHeight, [&](double x, double y) { return std::round(plane(x, y)); });
    double sum = 0, plain = 0;
    int n = 0;
    for (float y = 4; y < 26; y += 0.7f)
        for (float x = 4; x < 36; x += 0.7f, ++n) {
            sum += std::pow(sample(map, x, y) - plane(x, y), 2);
            plain += std::pow(map.at(static_cast<int>(x), static_cast<int>(y)) - plane(x, y), 2);
        }
    EXPECT_LT(std::sqrt(sum / n), 0.75 * std::sqrt(plain / n));
}

TEST(VertexDisparity, DoesNotMixAcrossAnEdge) {
    for (const double angle : {0.0, 0.5, 1.1, 1.57, 2.4}) {
        const auto side = [&](double x, double y) {
            return std::cos(angle) * (x - 20) + std::sin(angle) * (y - 15);
        };
        const DisparityMap map =
            make_map(kWidth, kHeight, [&](double x, double y) { return side(x, y) > 0 ? 50 : 20; });
        for (float y = 0; y <= kHeight; y += 0.37f)
            for (float x = 0; x <= kWidth; x += 0.41f) {
                const float d = sample(map, x, y);
                ASSERT_TRUE(d == 50 || d == 20) << d << " at " << x << ", " << y;
                if (std::abs(side(x, y)) > 1) {
                    ASSERT_EQ(d, side(x, y) > 0 ? 50 : 20) << x << ", " << y;
                }
            }
    }
}

TEST(VertexDisparity, UnknownPixelsAreIgnored) {
    std::mt19937 random(6);
    const auto plane = [](double x, double y) { return 30 + 0.3 * x - 0.2 * y; };
    DisparityMap map = make_map(kWidth, kHeight, plane);
    for (float& d : map.values)
        if (random() % 2 == 0) d = kUnknownDisparity;
    int known = 0;
    for (float y = 3; y < 27; y += 0.9f)
        for (float x = 3; x < 37; x += 0.9f) {
            const float d = sample(map, x, y);
            if (!std::isfinite(d)) continue;
            ++known;
            EXPECT_NEAR(d, plane(x, y), 0.8) << x << ", " << y;
        }
    EXPECT_GT(known, 900);
    for (float& d : map.values) d = kUnknownDisparity;
    EXPECT_EQ(sample(map, 20, 15), kUnknownDisparity);
}

TEST(VertexDisparity, OneKnownPixelGivesItsValue) {
    DisparityMap map = make_map(kWidth, kHeight, [](double, double) { return kUnknownDisparity; });
    map.at(20, 15) = 37.25f;
    EXPECT_EQ(sample(map, 20.5f, 15.5f), 37.25f);
    EXPECT_EQ(sample(map, 22.3f, 13.6f), 37.25f);
    EXPECT_EQ(sample(map, 24, 15), kUnknownDisparity) << "out of the window";
}

TEST(VertexDisparity, BackgroundIsUnknownAndNotMixedIn) {
    const DisparityMap map = make_map(kWidth, kHeight, [](double x, double) { return x < 20 ? 10.6 : 10; });
    EXPECT_EQ(sample(map, 30, 15, 10.5f), kUnknownDisparity);
    EXPECT_NEAR(sample(map, 19.4f, 15, 10.5f), 10.6, 1e-5) << "the background's 10 must not pull";
    EXPECT_EQ(sample(map, 30, 15), 10);
}

TEST(VertexDisparity, ZeroAndNegativeAreNoSurface) {
    const DisparityMap map = make_map(kWidth, kHeight, [](double x, double) { return x < 20 ? 0 : -3; });
    EXPECT_EQ(sample(map, 5, 5), kUnknownDisparity);
    EXPECT_EQ(sample(map, 30, 5), kUnknownDisparity);
}

TEST(VertexDisparity, ComesWithTheMesh) {
    const DensityMap density = flat_density(60, 60);
    DensityMap with_background = density;
    with_background.background_px = 15;
    const DisparityMap map = make_map(60, 60, [](double x, double) { return x < 30 ? 40 : 12; });
    MeshConfig config;
    config.t_max = 10;
    const MeshResult result = solve_mesh_cpu(with_background, map, config, 2, {});
    ASSERT_EQ(result.vertex_disparities.size(), result.mesh.positions.size());
    for (std::size_t i = 0; i < result.mesh.positions.size(); ++i) {
        const float x = result.mesh.positions[i].x;
        if (std::abs(x - 30) < 1) continue;
        EXPECT_EQ(result.vertex_disparities[i], x < 30 ? 40 : kUnknownDisparity) << "x " << x;
    }
}

}  // namespace
}  // namespace hexrelief::testing_mesher
