#include "pipeline/stages/depth.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hexrelief::stages {
namespace {

constexpr float kNone = kUnknownDepth;

// Returns a ramp that begins at 1 m and rises by 1 cm per pixel.
DepthMap ramp(int width, int height) {
    DepthMap map{width, height, std::vector<float>(static_cast<std::size_t>(width) * height)};
    for (std::size_t i = 0; i < map.values.size(); ++i) map.values[i] = 1 + 0.01f * static_cast<float>(i);
    return map;
}

TEST(Depth, DisparitiesAreFocalTimesBaselineOverDepthWithoutTheOffset) {
    const DepthMap map{3, 1, {2, 0.5f, kNone}};
    const DisparityMap disparities = disparities_of(map, {.focal_px = 100, .baseline_m = 0.2, .doffs_px = 3});
    ASSERT_EQ(disparities.width, 3);
    ASSERT_EQ(disparities.height, 1);
    EXPECT_FLOAT_EQ(disparities.values[0], 7);
    EXPECT_FLOAT_EQ(disparities.values[1], 37);
    EXPECT_FALSE(DisparityMap::known(disparities.values[2]));
}

TEST(Depth, RaysAreProjectedOnTheAxis) {
    // A sphere around the camera: every point is 5 m away.
    DepthMap map{40, 30, std::vector<float>(40 * 30, 5.0f)};
    map.values[7] = kNone;
    project_on_axis(map, {.focal_px = 30, .cx = 19.5, .cy = 10.5});
    EXPECT_FLOAT_EQ(map.values[10 * 40 + 19], 5) << "the principal point";
    EXPECT_FALSE(DepthMap::known(map.values[7]));
    for (const auto& [x, y] : {std::pair{0, 0}, {39, 29}, {3, 17}}) {
        const double z = map.values[y * 40 + x], u = (x + 0.5 - 19.5) / 30 * z, v = (y + 0.5 - 10.5) / 30 * z;
        EXPECT_NEAR(std::sqrt(u * u + v * v + z * z), 5, 1e-5) << x << ' ' << y;
    }
}

TEST(Depth, WhatLiesOutsideOfTheLimitsIsUnknown) {
    const auto kept = [](double nearest, double farthest) {
        DepthMap map{5, 1, {0.5f, 1, 2, 4, kNone}};
        keep_between(map, nearest, farthest);
        std::string known;
        for (const float depth : map.values) known += DepthMap::known(depth) ? '1' : '0';
        return known;
    };
    EXPECT_EQ(kept(0, 0), "11110");
    EXPECT_EQ(kept(1, 2), "01100");
    EXPECT_EQ(kept(1.5, 0), "00110");
    EXPECT_EQ(kept(0, 0.7), "10000");
}

TEST(Depth, TheBaselineIsAnEighthOfTheNearestDistance) {
    DepthMap map = ramp(100, 10);
    map.values[500] = 0.001f;  // one wrong pixel in a thousand does not matter
    EXPECT_NEAR(baseline_for(map, 700), 0.125 * 1.01, 1e-6);
    EXPECT_EQ(baseline_for({2, 1, {kNone, kNone}}, 700), 0);
    EXPECT_FLOAT_EQ(baseline_for({1, 1, {8}}, 700), 1);
}

TEST(Depth, TheBaselineIsSmallerForCoarseSamples) {
    const double focal_px = 700, usual = 0.125 * 1.02;
    DepthMap map = ramp(100, 10);
    map.step = 0.001;
    EXPECT_NEAR(baseline_for(map, focal_px), usual, 1e-6) << "millimetres are fine enough";
    const auto step_px = [&](double baseline) {
        return focal_px * baseline * (map.is_inverse ? map.step : map.step / (1.02 * 1.02));
    };
    map.step = 0.04;
    EXPECT_NEAR(step_px(baseline_for(map, focal_px)), 0.5, 1e-5);
    map.is_inverse = true;
    EXPECT_NEAR(step_px(baseline_for(map, focal_px)), 0.5, 1e-5);
    map.step = 1e-4;
    EXPECT_NEAR(baseline_for(map, focal_px), usual, 1e-6);
}

}  // namespace
}  // namespace hexrelief::stages
