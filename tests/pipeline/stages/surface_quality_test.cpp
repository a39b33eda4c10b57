// Tests measure_surface_quality() on scenes whose figures follow from simple arithmetic, and
// against a naive oracle.
#include "pipeline/stages/surface_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <random>

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 80, kHeight = 20;

DisparityMap map_of(const std::function<double(int, int)>& disparity, int width = kWidth,
                    int height = kHeight) {
    DisparityMap map{width, height, std::vector<float>(static_cast<std::size_t>(width) * height)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) map.at(x, y) = static_cast<float>(disparity(x, y));
    return map;
}

// Adds two triangles over [x0, x1] x [y0, y1], with disparity d0 at the left edge and d1 at the right one.
void add_strip(SurfaceMesh& mesh, double x0, double x1, double d0, double d1, double y0 = 0,
               double y1 = kHeight) {
    const auto first = static_cast<std::uint32_t>(mesh.disparities.size());
    for (const double y : {y0, y1})
        for (const bool right : {false, true}) {
            mesh.image_points.push_back({float(right ? x1 : x0), float(y)});
            mesh.disparities.push_back(float(right ? d1 : d0));
        }
    mesh.triangles.push_back({first, first + 2, first + 1});
    mesh.triangles.push_back({first + 1, first + 2, first + 3});
}

SurfaceMesh strip(double x0, double x1, double d0, double d1) {
    SurfaceMesh mesh;
    add_strip(mesh, x0, x1, d0, d1);
    return mesh;
}

TEST(SurfaceQuality, NothingIsWrongWithAnExactPlane) {
    const DisparityMap map = map_of([](int x, int) { return 10 + 0.25 * (x + 0.5); });
    const SurfaceQuality q = measure_surface_quality(strip(0, kWidth, 10, 30), map, 5, 1);
    EXPECT_NEAR(q.rmse_near_px, 0, 1e-5);
    EXPECT_NEAR(q.duo_rmse_near_px, 0, 1e-5);
    EXPECT_NEAR(q.flat_rmse_px, 0, 1e-5);
    EXPECT_EQ(q.coverage, 1);
    EXPECT_EQ(q.slack_coverage, 1);
    EXPECT_EQ(q.sheet_share, 0);
    EXPECT_EQ(q.scored_pixels, kWidth * kHeight);
    EXPECT_EQ(q.hidden_pixels, 0);
}

TEST(SurfaceQuality, AnErrorCountsUpToTheCap) {
    const DisparityMap map = map_of([](int, int) { return 20; });
    for (const double error : {0.5, -3.0, 9.0, 40.0}) {
        const SurfaceQuality q = measure_surface_quality(strip(0, kWidth, 20 + error, 20 + error), map, 5, 1);
        const double counted = std::min(std::fabs(error), kErrorCap_px);
        EXPECT_NEAR(q.rmse_near_px, counted, 1e-6) << error;
        EXPECT_NEAR(q.flat_rmse_px, counted, 1e-6) << error;
    }
}

// Half of the pixels, at 10 px, are wrong by 1 px, the other half, at 20 px, by 2 px: the near ones have
// 8 times the weight.
TEST(SurfaceQuality, NearErrorsWeighMore) {
    const DisparityMap map = map_of([](int x, int) { return x < 40 ? 10 : 20; });
    SurfaceMesh mesh = strip(0, 40, 11, 11);
    add_strip(mesh, 40, kWidth, 22, 22);
    EXPECT_NEAR(measure_surface_quality(mesh, map, 0, 1).rmse_near_px, std::sqrt((1 * 1 + 8 * 4) / 9.0),
                1e-6);
}

TEST(SurfaceQuality, WhatIsNotCoveredCountsAsTheCap) {
    const DisparityMap map = map_of([](int, int) { return 20; });
    const SurfaceQuality q = measure_surface_quality(strip(0, 20, 20, 20), map, 5, 1);
    EXPECT_DOUBLE_EQ(q.coverage, 0.25);
    EXPECT_NEAR(q.rmse_near_px, kErrorCap_px * std::sqrt(0.75), 1e-9);
}

TEST(SurfaceQuality, SlackForgivesHalfAPixelAtABorder) {
    const DisparityMap map = map_of([](int, int) { return 20; });
    const SurfaceQuality near = measure_surface_quality(strip(0.9, kWidth - 0.9, 20, 20), map, 5, 1);
    EXPECT_DOUBLE_EQ(near.coverage, 78.0 / 80);
    EXPECT_DOUBLE_EQ(near.slack_coverage, 1);
    EXPECT_NEAR(near.duo_rmse_near_px, 0, 1e-9);
    EXPECT_GT(near.rmse_near_px, 1);
    const SurfaceQuality far = measure_surface_quality(strip(1.1, kWidth - 1.1, 20, 20), map, 5, 1);
    EXPECT_DOUBLE_EQ(far.slack_coverage, 78.0 / 80);
    EXPECT_GT(far.duo_rmse_near_px, 1);
}

TEST(SurfaceQuality, BackgroundAndUnknownAreNotScored) {
    const DisparityMap map = map_of([](int x, int) {
        if (x < 20) return 4.0;
        return x < 40 ? double(kUnknownDisparity) : 20.0;
    });
    const SurfaceQuality q = measure_surface_quality(strip(40, kWidth, 20, 20), map, 5, 1);
    EXPECT_EQ(q.scored_pixels, 40 * kHeight);
    EXPECT_EQ(q.coverage, 1);
    EXPECT_NEAR(q.rmse_near_px, 0, 1e-6);
    EXPECT_EQ(q.hidden_pixels, 0) << "what lies behind unknown pixels is not known either";
}

// The surface is wrong by 5 px only within 2 px of a discontinuity, and flat_rmse_px ignores these pixels.
TEST(SurfaceQuality, FlatLeavesOutTheSurroundingsOfDiscontinuities) {
    const DisparityMap map = map_of([](int x, int) { return x < 40 ? 10 : 20; });
    SurfaceMesh mesh = strip(0, 38, 10, 10);
    add_strip(mesh, 38, 40, 15, 15);
    add_strip(mesh, 40, 42, 25, 25);
    add_strip(mesh, 42, kWidth, 20, 20);
    const SurfaceQuality q = measure_surface_quality(mesh, map, 0, 1);
    EXPECT_NEAR(q.flat_rmse_px, 0, 1e-6);
    EXPECT_GT(q.rmse_near_px, 1);
}

// A post at 20 px in front of a wall at 10 px hides 10 px of the wall from the left camera,
// right of the post.
DisparityMap post() {
    return map_of([](int x, int) { return x >= 30 && x < 60 ? 20 : 10; });
}

SurfaceMesh post_mesh(bool bridged) {
    SurfaceMesh mesh = strip(0, 30, 10, 10);
    if (bridged) {
        add_strip(mesh, 30, 59.5, 20, 20);
        add_strip(mesh, 59.5, 60.5, 20, 10);
        add_strip(mesh, 60.5, kWidth, 10, 10);
    } else {
        add_strip(mesh, 30, 60, 20, 20);
        add_strip(mesh, 60, kWidth, 10, 10);
    }
    return mesh;
}

TEST(SurfaceQuality, ARubberSheetIsSeenFromTheOtherSide) {
    const SurfaceQuality cut = measure_surface_quality(post_mesh(false), post(), 0, 1);
    EXPECT_EQ(cut.hidden_pixels, 10 * kHeight);
    EXPECT_EQ(cut.sheet_share, 0);
    EXPECT_NEAR(cut.duo_rmse_near_px, 0, 1e-6);

    // In the right view the mesh falls from 20 to 10 px between x = 39.5 and 50.5, over the pixel
    // centres 40.5 .. 49.5.
    const SurfaceQuality bridged = measure_surface_quality(post_mesh(true), post(), 0, 1);
    double weight = 0, squares = 0;
    int rubber_sheet = 0;
    for (int x = 40; x < 50; ++x) {
        const double d = 20 - 10 * (x + 0.5 - 39.5) / 11;
        const double error = d > 11 ? d - 10 : 0, near = std::pow((d > 11 ? d : 10) / 20, 3);
        rubber_sheet += d > 11;
        weight += near;
        squares += near * error * error;
    }
    weight += 30 + 50 / 8.0;  // the left view's pixels, none of which is wrong
    EXPECT_EQ(rubber_sheet, 9);
    EXPECT_DOUBLE_EQ(bridged.sheet_share, 0.9);
    EXPECT_NEAR(bridged.duo_rmse_near_px, std::sqrt(squares / weight), 1e-5);
    EXPECT_NEAR(bridged.rmse_near_px, 0, 1e-6) << "one view alone does not see it";
}

TEST(HiddenFromLeft, SlantedSurfacesHideNothing) {
    const DisparityMap map = map_of([](int x, int y) { return 5 + 0.9 * x + 0.1 * y; });
    for (const float d : hidden_from_left(map, 2)) EXPECT_EQ(d, 0);
}

TEST(HiddenFromLeft, TheGapContinuesTheFartherSilhouette) {
    const std::vector<float> hidden = hidden_from_left(post(), 2);
    for (int x = 0; x < kWidth; ++x) EXPECT_EQ(hidden[x], x >= 40 && x < 50 ? 10 : 0) << x;
}

// ---- a naive oracle: every pixel is tested against every triangle ----

std::optional<double> disparity_at(const SurfaceMesh& mesh, bool right, double x, double y) {
    std::optional<double> top;
    for (const Triangle& t : mesh.triangles) {
        double px[3], py[3], d[3];
        for (int k = 0; k < 3; ++k) {
            d[k] = mesh.disparities[t[k]];
            px[k] = mesh.image_points[t[k]].x - (right ? d[k] : 0);
            py[k] = mesh.image_points[t[k]].y;
        }
        const auto area = [&](double ax, double ay, double bx, double by, double cx, double cy) {
            return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        };
        const double whole = area(px[0], py[0], px[1], py[1], px[2], py[2]);
        if (std::fabs(whole) < 1e-9) continue;
        const double a = area(x, y, px[1], py[1], px[2], py[2]) / whole,
                     b = area(px[0], py[0], x, y, px[2], py[2]) / whole, c = 1 - a - b;
        if (std::min({a, b, c}) < 0) continue;
        top = std::max(top.value_or(-1e9), a * d[0] + b * d[1] + c * d[2]);
    }
    return top;
}

TEST(SurfaceQuality, AgreesWithTheNaiveOracleOnHeapsOfTriangles) {
    constexpr int kSide = 40;
    std::mt19937 random(7);
    const auto draw = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
    };
    const DisparityMap map =
        map_of([](int x, int y) { return x < 18 ? 12 + 0.1 * y : 4 + 0.2 * x - 0.05 * y; }, kSide, kSide);
    SurfaceMesh mesh;
    for (std::uint32_t i = 0; i < 60; ++i) {
        const double x = draw(-3, kSide), y = draw(-3, kSide), d = draw(2, 16);
        for (int k = 0; k < 3; ++k) {
            mesh.image_points.push_back({float(x + draw(-6, 9)), float(y + draw(-6, 9))});
            mesh.disparities.push_back(float(d + draw(-2, 2)));
        }
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    mesh.triangles.push_back({0, 0, 1});  // without area

    double largest = 0;
    for (const float d : map.values) largest = std::max<double>(largest, d);
    double weight = 0, squares = 0;
    int covered = 0, rubber_sheet = 0, hidden = 0;
    const std::vector<float> behind = hidden_from_left(map, 1);
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const double d = map.at(x, y), near = std::pow(d / largest, 3);
            const std::optional<double> seen = disparity_at(mesh, false, x + 0.5, y + 0.5);
            const double error = seen ? std::min(std::fabs(*seen - d), 10.0) : 10;
            weight += near;
            squares += near * error * error;
            covered += seen.has_value();
            const double back = behind[static_cast<std::size_t>(y) * kSide + x];
            if (!(back > 0)) continue;
            ++hidden;
            rubber_sheet += disparity_at(mesh, true, x + 0.5, y + 0.5).value_or(0) > back + 1;
        }
    ASSERT_GT(hidden, 50);
    ASSERT_GT(rubber_sheet, 5);
    const SurfaceQuality q = measure_surface_quality(mesh, map, 0, 1);
    EXPECT_NEAR(q.rmse_near_px, std::sqrt(squares / weight), 1e-5);
    EXPECT_DOUBLE_EQ(q.coverage, covered / double(kSide * kSide));
    EXPECT_DOUBLE_EQ(q.sheet_share, rubber_sheet / double(hidden));

    const SurfaceQuality threaded = measure_surface_quality(mesh, map, 0, 3);
    EXPECT_EQ(threaded.rmse_near_px, q.rmse_near_px);
    EXPECT_EQ(threaded.duo_rmse_near_px, q.duo_rmse_near_px);
    EXPECT_EQ(threaded.flat_rmse_px, q.flat_rmse_px);
    EXPECT_EQ(threaded.slack_coverage, q.slack_coverage);
}

TEST(SurfaceQuality, AMapThatKnowsNothingIsNoError) {
    const DisparityMap map = map_of([](int, int) { return double(kUnknownDisparity); });
    const SurfaceQuality q = measure_surface_quality(strip(0, kWidth, 20, 20), map, 0, 1);
    EXPECT_EQ(q.scored_pixels, 0);
    EXPECT_EQ(q.rmse_near_px, 0);
}

}  // namespace
}  // namespace hexrelief::stages
