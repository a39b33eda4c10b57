// Tests where density.detail moves the mesh's vertices to.
#include "pipeline/stages/density_detail.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "pipeline/stages/density.h"
#include "tests/expect_error.h"

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 160, kHeight = 120;

DisparityMap map_of(const std::function<double(double, double)>& disparity, int scale = 1) {
    DisparityMap map{kWidth * scale, kHeight * scale, {}};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            map.values.push_back(static_cast<float>(disparity(double(x) / scale, double(y) / scale)));
    return map;
}

double mean(const std::vector<float>& density, int x0, int x1, int y0 = 20, int y1 = 100) {
    double sum = 0;
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) sum += density[static_cast<std::size_t>(y) * kWidth + x];
    return sum / ((x1 - x0) * (y1 - y0));
}

// A near slanted wall at the left; far ripples with a curvature of up to 0.12 / px at the right.
double wall_and_ripples(double x, double y) {
    if (x < 80) return 40 + 0.1 * y + 0.2 * x;
    return 15 + 3 * std::sin(x / 5);
}

TEST(DensityDetail, PlanesWantNothing) {
    const DisparityMap map = map_of([](double x, double y) { return 10 + 0.1 * x + 0.2 * y; });
    const std::vector<float> detail = detail_density(map, 5);
    EXPECT_EQ(*std::max_element(detail.begin(), detail.end()), 0);
    DensityConfig with, without;
    with.detail = 0.5;
    EXPECT_EQ(compute_density(map, with).values, compute_density(map, without).values);
}

TEST(DensityDetail, CurvatureAndDiscontinuitiesWantMore) {
    const std::vector<float> detail = detail_density(map_of(wall_and_ripples), 5);
    const double wall = mean(detail, 10, 60), ripples = mean(detail, 100, 140),
                 discontinuity = mean(detail, 76, 84);
    EXPECT_LT(wall, 0.02);
    EXPECT_GT(ripples, 0.1);
    EXPECT_GT(discontinuity, ripples);
    for (const float value : detail) {
        EXPECT_GE(value, 0);
        EXPECT_LE(value, 1);
    }
}

// Cells share c^2 A^2 evenly if their density is curvature^(2/3).
TEST(DensityDetail, GrowsAsTheTwoThirdsPowerOfCurvature) {
    const DisparityMap map = map_of([](double x, double) {
        const double u = x - 40, v = x - 120;
        if (x < 10) return 20.0;  // a plane, whose residuals are the noise that is subtracted
        return x < 80 ? 20 + 0.05 * u * u : 20 + 0.4 * v * v;
    });
    const std::vector<float> detail = detail_density(map, 1);
    EXPECT_NEAR(mean(detail, 115, 125) / mean(detail, 35, 45), std::pow(8, 2.0 / 3), 0.12);
}

TEST(DensityDetail, TakesOffTheMapsNoise) {
    const auto noise = [](double u, double v) {
        const int x = int(u), y = int(v);
        return 0.25 * ((x * 7919 + y * 104729 + x * y * 31) % 17) / 17.0;
    };
    const std::vector<float> detail =
        detail_density(map_of([&](double x, double y) { return wall_and_ripples(x, y) + noise(x, y); }), 5);
    EXPECT_LT(mean(detail, 10, 60), 0.6 * mean(detail, 100, 140));
}

TEST(DensityDetail, BackgroundAndUnknownStayEmpty) {
    const DisparityMap map = map_of([](double x, double y) {
        if (x < 30) return double(kUnknownDisparity);
        return x < 60 ? 3.0 : wall_and_ripples(x, y);
    });
    const std::vector<float> detail = detail_density(map, 5);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < 60; ++x) EXPECT_EQ(detail[static_cast<std::size_t>(y) * kWidth + x], 0);
}

// Large images are divided into blocks: the same scene at four times the size has the same density.
TEST(DensityDetail, ScalesWithTheImage) {
    const int scale = 8;
    const DisparityMap large = map_of(wall_and_ripples, scale);
    const std::vector<float> detail = detail_density(large, 5);
    const auto at = [&](int x, int y) { return detail[std::size_t(y * scale) * large.width + x * scale]; };
    EXPECT_LT(at(30, 60), 0.05);
    EXPECT_GT(at(81, 60), 0.3);
}

TEST(Density, DetailIsAShareOfTheWhole) {
    const DisparityMap map = map_of(wall_and_ripples);
    const auto ripples_share = [&](double detail) {
        const std::vector<float> density = compute_density(map, {.detail = detail}).values;
        EXPECT_EQ(*std::max_element(density.begin(), density.end()), 1);
        return mean(density, 84, kWidth) * (kWidth - 84) / (mean(density, 0, kWidth) * kWidth);
    };
    const double cube = ripples_share(0), half = ripples_share(0.5), most = ripples_share(0.9);
    EXPECT_LT(cube, half);
    EXPECT_LT(half, most);
    // Half of the sum is the cube's, half is the detail's.
    const std::vector<float> detail = detail_density(map, compute_density(map, {}).background_px);
    const double pure = mean(detail, 84, kWidth) * (kWidth - 84) / (mean(detail, 0, kWidth) * kWidth);
    EXPECT_NEAR(half, 0.5 * (cube + pure), 0.02);
}

TEST(Density, DetailIsCheckedForItsRange) {
    EXPECT_CONTAINS(
        test::error_of([&] { compute_density(map_of(wall_and_ripples), {.detail = 1}); }, ErrorKind::usage),
        "density.detail");
}

}  // namespace
}  // namespace hexrelief::stages
