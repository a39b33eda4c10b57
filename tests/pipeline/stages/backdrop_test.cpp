#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "pipeline/stages/disparity_range.h"

namespace hexrelief::stages {
namespace {

// A floor from 40 px at the bottom to 8 px at the top, all of it matched.
DisparityMap floor_map() {
    DisparityMap map{100, 120, {}};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) map.values.push_back(8 + 32 * static_cast<float>(y) / 119);
    map.origins.assign(map.values.size(), PixelOrigin::matched);
    return map;
}

float least_of(const DisparityMap& map) {
    return *std::min_element(map.values.begin(), map.values.end());
}

TEST(Backdrop, LeavesAMapWhoseMatchesReachItsEnd) {
    DisparityMap map = floor_map();
    const std::vector<float> before = map.values;
    const auto backdrop = put_backdrop(map, 0, 0, 1.1);
    ASSERT_TRUE(backdrop);
    EXPECT_NEAR(backdrop->disparity_px, 8.27 / 1.1, 0.01);
    EXPECT_EQ(backdrop->moved_share, 0);
    EXPECT_EQ(map.values, before);
}

TEST(Backdrop, EndsWhatIsFilledFarBehindTheMatches) {
    DisparityMap map = floor_map();
    for (std::size_t i = 0; i < 2400; ++i) {
        map.values[i] = 0.0625f;
        map.origins[i] = PixelOrigin::filled;
    }
    map.values[5] = kUnknownDisparity;
    const auto backdrop = put_backdrop(map, 0, 0, 1.1);
    ASSERT_TRUE(backdrop);
    EXPECT_NEAR(backdrop->moved_share, 2399 / 11999.0, 1e-9);
    EXPECT_FLOAT_EQ(least_of(map), backdrop->disparity_px);
    EXPECT_GT(backdrop->disparity_px, 12);  // the twenty rows of the farthest floor are gone
    EXPECT_FALSE(DisparityMap::known(map.values[5]));
}

TEST(Backdrop, AFewMatchesFarBehindAreNoEvidence) {
    DisparityMap map = floor_map();
    for (std::size_t i = 0; i < 50; ++i) map.values[i * 233] = 2;  // 0.4 %
    ASSERT_TRUE(put_backdrop(map, 0, 0, 1.1));
    EXPECT_NEAR(least_of(map), 8 / 1.1, 0.1);
}

TEST(Backdrop, MatchesAtTheEndOfTheSearchAreNoEvidence) {
    for (const int min_px : {0, -20}) {
        DisparityMap map = floor_map();
        for (float& d : map.values) d += static_cast<float>(min_px);
        for (std::size_t i = 0; i < 1200; ++i) map.values[i] = static_cast<float>(min_px) + 0.5f;
        const auto backdrop = put_backdrop(map, min_px, -min_px, 1.25);
        ASSERT_TRUE(backdrop);
        EXPECT_NEAR(backdrop->disparity_px - static_cast<float>(min_px), 11.5 / 1.25, 0.1);
        EXPECT_NEAR(backdrop->moved_share, 0.1, 1e-9);
    }
}

TEST(Backdrop, IsAtMostTenTimesAsFarAsTheMiddle) {
    DisparityMap map = floor_map();
    for (float& d : map.values) d = 100;
    for (std::size_t i = 0; i < 1200; ++i) map.values[i] = 2;  // a tenth, far away
    const auto backdrop = put_backdrop(map, 0, 0, 1);
    ASSERT_TRUE(backdrop);
    EXPECT_FLOAT_EQ(backdrop->disparity_px, 10);
    EXPECT_FLOAT_EQ(least_of(map), 10);
}

// Depths are proportional to 1 / (d + doffs).
TEST(Backdrop, CountsFromInfinity) {
    DisparityMap map = floor_map(), shifted = map;
    for (std::size_t i = 0; i < 600; ++i) map.values[i] = 1.5f;
    for (std::size_t i = 0; i < map.values.size(); ++i) shifted.values[i] = map.values[i] - 30;
    put_backdrop(map, 0, 0, 1.1);
    put_backdrop(shifted, -30, 30, 1.1);
    for (std::size_t i = 0; i < map.values.size(); ++i)
        ASSERT_NEAR(shifted.values[i] + 30, map.values[i], 1e-4);
}

TEST(Backdrop, WithoutMatchesThereIsNone) {
    DisparityMap map = floor_map();
    map.origins.assign(map.values.size(), PixelOrigin::filled);
    const std::vector<float> before = map.values;
    EXPECT_FALSE(put_backdrop(map, 0, 0, 1.1));
    EXPECT_EQ(map.values, before);
}

TEST(Near, WhatIsNearerThanTheMatchesLiesWhereItsSurroundingsDo) {
    DisparityMap map = floor_map();
    for (float& d : map.values) d = 20;
    for (int y = 50; y < 60; ++y)
        for (int x = 40; x < 45; ++x) map.at(x, y) = 60;
    map.at(0, 0) = 31;
    map.at(1, 0) = map.at(0, 1) = kUnknownDisparity;
    map.at(70, 70) = 29;
    EXPECT_EQ(press_near(map, 30), 51u);
    EXPECT_EQ(map.at(42, 55), 20);
    EXPECT_EQ(map.at(0, 0), 30);  // nothing around it is known
    EXPECT_EQ(map.at(70, 70), 29);
    EXPECT_FALSE(DisparityMap::known(map.at(1, 0)));
}

TEST(Near, ASlopeEndsAtTheNearestMatches) {
    DisparityMap map = floor_map();
    EXPECT_GT(press_near(map, 30), 0u);
    EXPECT_NEAR(*std::max_element(map.values.begin(), map.values.end()), 30, 0.3);
    const std::vector<float> before = map.values;
    EXPECT_EQ(press_near(map, std::numeric_limits<double>::infinity()), 0u);
    EXPECT_EQ(map.values, before);
}

}  // namespace
}  // namespace hexrelief::stages
