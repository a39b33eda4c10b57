// Tests that a near surface ends where its colours do.
#include "pipeline/stages/by_colour/rims.h"

#include <gtest/gtest.h>

#include <cmath>

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
        const DisparityMap map = with_rims_by_colour(thing_from(matched), dark_from(200));
        EXPECT_EQ(map.values, thing_from(200).values) << matched;
    }
}

TEST(RimsByColour, ScrapsBetweenBothGoToTheSideOfTheirColour) {
    DisparityMap map = thing_from(200);
    for (int y = 10; y < 20; ++y)
        for (int x = 199; x < 202; ++x) map.at(x, y) = 35 + static_cast<float>(x % 2);
    EXPECT_EQ(with_rims_by_colour(map, dark_from(200)).values, thing_from(200).values);
    EXPECT_EQ(with_rims_by_colour(map, dark_from(202)).at(201, 15), kFar_px);
}

TEST(RimsByColour, WhatTurnsAwayKeepsItsSlope) {
    DisparityMap map = thing_from(200);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 200; x < 210; ++x) map.at(x, y) = kNear_px - 0.8f * static_cast<float>(210 - x);
    EXPECT_EQ(with_rims_by_colour(map, dark_from(200)).values, map.values);
}

TEST(RimsByColour, NarrowThingsAndGapsStay) {
    DisparityMap thing = thing_from(kWidth), gap = thing_from(0);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 200; x < 204; ++x) thing.at(x, y) = kNear_px, gap.at(x, y) = kFar_px;
    for (const DisparityMap& map : {thing, gap})
        EXPECT_EQ(with_rims_by_colour(map, dark_from(kWidth)).values, map.values);
}

TEST(RimsByColour, AGleamOfTheOtherColourStaysIfMostAroundDo) {
    Image left = dark_from(200);
    for (int x = 200; x < 203; ++x) left.pixels[20 * kWidth + x] = kLight;
    const DisparityMap map = with_rims_by_colour(thing_from(200), left);
    EXPECT_EQ(map.at(201, 20), kNear_px);
    EXPECT_EQ(map.at(202, 20), kNear_px);
}

TEST(RimsByColour, FarFromAStepAndWithLowStepsNothingMoves) {
    const DisparityMap map = thing_from(200);
    // The colours end beyond the band.
    const DisparityMap moved = with_rims_by_colour(map, dark_from(220));
    for (int x = 204; x < kWidth; ++x) EXPECT_EQ(moved.at(x, 20), kNear_px) << x;
    DisparityMap low = map;
    for (float& d : low.values) d = d == kNear_px ? kFar_px + 2 : d;
    EXPECT_EQ(with_rims_by_colour(low, dark_from(198)).values, low.values);
}

TEST(RimsByColour, UnknownPixelsAndOriginsStay) {
    DisparityMap map = thing_from(198);
    map.origins.assign(map.values.size(), PixelOrigin::filled);
    map.at(198, 20) = map.at(300, 20) = kUnknownDisparity;
    const DisparityMap result = with_rims_by_colour(map, dark_from(200));
    EXPECT_EQ(result.origins, map.origins);
    EXPECT_EQ(result.at(198, 20), kUnknownDisparity);
    EXPECT_EQ(result.at(300, 20), kUnknownDisparity);
    EXPECT_EQ(result.at(198, 30), kFar_px);
    EXPECT_TRUE(with_rims_by_colour({}, {}).values.empty());
    EXPECT_EQ(with_rims_by_colour(map, {}).at(198, 30), kNear_px);  // no picture
}

}  // namespace
}  // namespace hexrelief::stages
