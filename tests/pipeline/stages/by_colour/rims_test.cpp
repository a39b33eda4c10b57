// Tests that a near surface ends where its colours do.
#include "pipeline/stages/by_colour/rims.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 480, kHeight = 40;  // the band has 4 px on the near side, 1 px on the far one
constexpr float kNear_px = 60, kFar_px = 20;
constexpr std::uint8_t kDark = 60, kLight = 200;

// The near surface from column `first` on, before a wall.
DisparityMap thing_from(int first) {
    DisparityMap map{kWidth, kHeight, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) map.values.push_back(x >= first ? kNear_px : kFar_px);
    return map;
}

Image dark_from(int first) {
    Image left{kWidth, kHeight, 1, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) left.pixels.push_back(x >= first ? kDark : kLight);
    return left;
}

TEST(RimsByColour, LoseTheirHaloAndGetBackWhatIsTheirs) {
    for (const int matched : {198, 199, 200, 201}) {
        const DisparityMap map = with_rims_by_colour(thing_from(matched), dark_from(200), 2);
        EXPECT_EQ(map.values, thing_from(200).values) << matched;
    }
}

TEST(RimsByColour, ScrapsBetweenBothGoToTheSideOfTheirColour) {
    DisparityMap map = thing_from(200);
    for (int y = 10; y < 20; ++y)
        for (int x = 199; x < 202; ++x) map.at(x, y) = 35 + static_cast<float>(x % 2);
    EXPECT_EQ(with_rims_by_colour(map, dark_from(200), 2).values, thing_from(200).values);
    EXPECT_EQ(with_rims_by_colour(map, dark_from(202), 2).at(201, 15), kFar_px);
}

TEST(RimsByColour, WhatTurnsAwayKeepsItsSlope) {
    DisparityMap map = thing_from(200);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 200; x < 210; ++x) map.at(x, y) = kNear_px - 0.8f * static_cast<float>(210 - x);
    EXPECT_EQ(with_rims_by_colour(map, dark_from(200), 2).values, map.values);
}

TEST(RimsByColour, NarrowThingsAndGapsStay) {
    DisparityMap thing = thing_from(kWidth), gap = thing_from(0);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 200; x < 204; ++x) thing.at(x, y) = kNear_px, gap.at(x, y) = kFar_px;
    for (const DisparityMap& map : {thing, gap})
        EXPECT_EQ(with_rims_by_colour(map, dark_from(kWidth), 2).values, map.values);
}

TEST(RimsByColour, AGleamOfTheOtherColourStaysIfMostAroundDo) {
    Image left = dark_from(200);
    for (int x = 200; x < 203; ++x) left.pixels[20 * kWidth + x] = kLight;
    const DisparityMap map = with_rims_by_colour(thing_from(200), left, 2);
    EXPECT_EQ(map.at(201, 20), kNear_px);
    EXPECT_EQ(map.at(202, 20), kNear_px);
}

TEST(RimsByColour, FarFromAStepAndWithLowStepsNothingMoves) {
    const DisparityMap map = thing_from(200);
    // The colours end beyond the band.
    const DisparityMap moved = with_rims_by_colour(map, dark_from(220), 2);
    for (int x = 204; x < kWidth; ++x) EXPECT_EQ(moved.at(x, 20), kNear_px) << x;
    DisparityMap low = map;
    for (float& d : low.values) d = d == kNear_px ? kFar_px + 2 : d;
    EXPECT_EQ(with_rims_by_colour(low, dark_from(198), 2).values, low.values);
}

TEST(RimsByColour, UnknownPixelsAndOriginsStay) {
    DisparityMap map = thing_from(198);
    map.origins.assign(map.values.size(), PixelOrigin::filled);
    map.at(198, 20) = map.at(300, 20) = kUnknownDisparity;
    const DisparityMap result = with_rims_by_colour(map, dark_from(200), 2);
    EXPECT_EQ(result.origins, map.origins);
    EXPECT_EQ(result.at(198, 20), kUnknownDisparity);
    EXPECT_EQ(result.at(300, 20), kUnknownDisparity);
    EXPECT_EQ(result.at(198, 30), kFar_px);
    EXPECT_TRUE(with_rims_by_colour({}, {}, 2).values.empty());
    EXPECT_EQ(with_rims_by_colour(map, {}, 2).at(198, 30), kNear_px);  // no picture
}

// A rough near thing before a rough wall, with shreds at its rim: mirrored, in three channels and on more
// threads it becomes the same.
TEST(RimsByColour, DoNotDependOnTheOrderOfPixelsChannelsOrThreads) {
    DisparityMap map = thing_from(200), mirrored = map;
    Image left = dark_from(200), mirrored_left = left, colour{kWidth, kHeight, 3, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            map.at(x, y) += 0.3f * static_cast<float>(y % 7) + 0.4f * static_cast<float>(x % 3);
            if (x >= 199 && x < 203 && y % 13 < 9) map.at(x, y) = 30 + static_cast<float>(y % 7);
            *left.at(x, y) = static_cast<std::uint8_t>((x >= 203 ? 110 : 126) + (x * 13 + y * 29) % 3 % 2);
            mirrored.at(kWidth - 1 - x, y) = map.at(x, y);
            *mirrored_left.at(kWidth - 1 - x, y) = *left.at(x, y);
            colour.pixels.insert(colour.pixels.end(), 3, *left.at(x, y));
        }
    const DisparityMap result = with_rims_by_colour(map, left, 1);
    EXPECT_NE(result.values, map.values);
    EXPECT_EQ(with_rims_by_colour(map, left, 7).values, result.values);
    EXPECT_EQ(with_rims_by_colour(map, colour, 2).values, result.values);
    const DisparityMap other = with_rims_by_colour(mirrored, mirrored_left, 2);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            EXPECT_EQ(other.at(kWidth - 1 - x, y), result.at(x, y)) << x << ", " << y;
}

TEST(RimsByColour, MapsOfARowAndOfAColumn) {
    for (const auto& [width, height] : {std::pair{300, 1}, {1, 300}}) {
        DisparityMap map{width, height, std::vector<float>(300, kFar_px)};
        std::fill(map.values.begin() + 150, map.values.end(), kNear_px);
        Image left{width, height, 1, std::vector<std::uint8_t>(300, kLight)};
        std::fill(left.pixels.begin() + 152, left.pixels.end(), kDark);
        EXPECT_EQ(with_rims_by_colour(map, left, 3).values[151], kFar_px);
    }
}

}  // namespace
}  // namespace hexrelief::stages
