#include "pipeline/stages/densify/densify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace hexrelief::stages {
namespace {

constexpr int kColumns = 160, kRows = 120;

// A bright disc in front of a dark, slanted wall.
bool is_disc(int x, int y, int radius = 30) {
    return (x - 80) * (x - 80) + (y - 60) * (y - 60) < radius * radius;
}

float disparity(int x, int y, int radius = 30) {
    return is_disc(x, y, radius) ? 30.0F
                                 : 10.0F + 0.03F * static_cast<float>(x) + 0.02F * static_cast<float>(y);
}

Image picture() {
    Image image{kColumns, kRows, 3, {}};
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x)
            for (int c = 0; c < 3; ++c)
                image.pixels.push_back(
                    static_cast<std::uint8_t>((is_disc(x, y) ? 180 : 60) + (7 * x + 11 * y + 5 * c) % 17));
    return image;
}

DisparityMap true_map(int radius = 30) {
    DisparityMap map{kColumns, kRows, {}};
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) map.values.push_back(disparity(x, y, radius));
    return map;
}

// Means over a disc, which are smooth like a network's maps.
DisparityMap blurred(const DisparityMap& map, int radius) {
    DisparityMap result = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            float sum = 0, weights = 0;
            for (int v = std::max(0, y - radius); v <= std::min(map.height - 1, y + radius); ++v)
                for (int u = std::max(0, x - radius); u <= std::min(map.width - 1, x + radius); ++u) {
                    const int far = (u - x) * (u - x) + (v - y) * (v - y);
                    const float weight = static_cast<float>(std::max(0, radius * radius + 1 - far));
                    sum += weight * map.at(u, v);
                    weights += weight;
                }
            result.at(x, y) = sum / weights;
        }
    return result;
}

int wrong_pixels(const DisparityMap& map) {
    int wrong = 0;
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) wrong += !(std::abs(map.at(x, y) - disparity(x, y)) <= 1);
    return wrong;
}

TEST(BlurredSteps, AreCutAlongThePicturesEdges) {
    for (const int radius : {3, 5}) {
        const DisparityMap map = blurred(true_map(), radius);
        const SharpenedMap sharp = sharpen_steps(map, picture(), 2);
        EXPECT_GT(sharp.blurred_share, 0.02) << radius;
        EXPECT_GT(wrong_pixels(map), 400) << radius;
        EXPECT_LT(wrong_pixels(sharp.map), wrong_pixels(map) / 3) << radius;
        EXPECT_EQ(sharpen_steps(map, picture(), 1).map.values, sharp.map.values) << radius;
    }
}

TEST(BlurredSteps, ColoursDecideWhereAThingBleeds) {
    const DisparityMap map = blurred(true_map(33), 3);
    EXPECT_LT(wrong_pixels(sharpen_steps(map, picture(), 2).map), wrong_pixels(map) / 4);
}

TEST(BlurredSteps, PixelsKeepTheirSideWhereColoursSayNothing) {
    const DisparityMap map = blurred(true_map(), 3);
    Image noise = picture();
    std::uint32_t random = 7;
    for (std::uint8_t& level : noise.pixels) {
        random = random * 1664525 + 1013904223;
        level = static_cast<std::uint8_t>(random >> 24);
    }
    EXPECT_LT(wrong_pixels(sharpen_steps(map, noise, 2).map), wrong_pixels(map) / 3);
}

TEST(BlurredSteps, SharpMapsAndSmoothSurfacesStayAsTheyAre) {
    DisparityMap round{kColumns, kRows, {}}, wave = round;
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) {
            const float from_middle = std::hypot(static_cast<float>(x - 80), static_cast<float>(y - 60));
            round.values.push_back(10 + std::sqrt(std::max(0.0F, 50 * 50 - from_middle * from_middle)) / 2);
            wave.values.push_back(20 + 6 * std::sin(static_cast<float>(x + y) / 12));
        }
    for (const DisparityMap& map : {true_map(), round, wave}) {
        const SharpenedMap same = sharpen_steps(map, picture(), 2);
        EXPECT_EQ(same.blurred_share, 0);
        EXPECT_EQ(same.map.values, map.values);
    }
}

TEST(BlurredSteps, WhatIsUnknownStaysUnknown) {
    DisparityMap map = blurred(true_map(), 5);
    for (int x = 0; x < kColumns; ++x) map.at(x, 60) = kUnknownDisparity;
    const SharpenedMap sharp = sharpen_steps(map, picture(), 2);
    EXPECT_GT(sharp.blurred_share, 0);
    for (int x = 0; x < kColumns; ++x) EXPECT_FALSE(DisparityMap::known(sharp.map.at(x, 60)));
}

}  // namespace
}  // namespace hexrelief::stages
