// Tests that a near surface gets back the part of it that was filled from behind.
#include "pipeline/stages/by_colour/filled_rims.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace hexrelief::stages {
namespace {

constexpr int kColumns = 480, kRows = 40;           // filled rims are up to 8 px wide
constexpr int kContourAt = 200, kHiddenFrom = 160;  // from these columns on
constexpr float kBefore_px = 60, kSeenBehind_px = 20;

// A near thing, matched from column `matched` on, before a wall whose part beside it was filled.
DisparityMap thing_matched_from(int matched) {
    DisparityMap map{kColumns, kRows, {}};
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) {
            map.values.push_back(x >= matched ? kBefore_px : kSeenBehind_px);
            const bool is_filled = x >= kHiddenFrom && x < matched;
            map.origins.push_back(is_filled ? PixelOrigin::filled : PixelOrigin::matched);
        }
    return map;
}

Image picture_of_thing() {
    constexpr std::uint8_t kDark = 60, kLight = 200;
    Image left{kColumns, kRows, 1, {}};
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) left.pixels.push_back(x >= kContourAt ? kDark : kLight);
    return left;
}

TEST(FilledRims, JoinTheNearSurfaceUpToTheContour) {
    for (const int matched : {kContourAt, kContourAt + 3, kContourAt + 6}) {
        const DisparityMap map = thing_matched_from(matched);
        const DisparityMap joined = with_filled_rims_joined(map, picture_of_thing(), 2);
        EXPECT_EQ(joined.values, thing_matched_from(kContourAt).values) << matched;
        EXPECT_EQ(joined.origins, map.origins) << matched;
    }
}

TEST(FilledRims, BetweenNearSurfacesAreSmooth) {
    DisparityMap map = thing_matched_from(kContourAt + 6);
    for (int y = 0; y < kRows / 2; ++y)
        for (int x = kContourAt + 6; x < kColumns; ++x) map.at(x, y) = kBefore_px + 4;
    const DisparityMap joined = with_filled_rims_joined(map, picture_of_thing(), 2);
    for (int y = 1; y < kRows; ++y) {
        EXPECT_NEAR(joined.at(kContourAt, y), joined.at(kContourAt, y - 1), 1) << y;
        EXPECT_GE(joined.at(kContourAt, y), kBefore_px) << y;
    }
}

TEST(FilledRims, MatchedPixelsStay) {
    DisparityMap map = thing_matched_from(kContourAt + 6);
    map.origins.assign(map.origins.size(), PixelOrigin::matched);
    EXPECT_EQ(with_filled_rims_joined(map, picture_of_thing(), 2).values, map.values);
}

TEST(FilledRims, WithoutAContourBehindOrWithOneBeforeItNothingMoves) {
    // Too wide: the contour is out of reach, or lies where the map has its step.
    for (const int matched : {kContourAt - 6, kContourAt, kContourAt + 20}) {
        const DisparityMap map = thing_matched_from(matched);
        EXPECT_EQ(with_filled_rims_joined(map, picture_of_thing(), 2).values, map.values) << matched;
    }
    const Image bare{kColumns, kRows, 1, std::vector<std::uint8_t>(kColumns * kRows, 100)};
    const DisparityMap map = thing_matched_from(kContourAt + 6);
    EXPECT_EQ(with_filled_rims_joined(map, bare, 2).values, map.values);
}

TEST(FilledRims, WithoutPictureOrOriginsNothingMoves) {
    DisparityMap map = thing_matched_from(kContourAt + 6);
    EXPECT_EQ(with_filled_rims_joined(map, {}, 2).values, map.values);
    map.origins.clear();
    EXPECT_EQ(with_filled_rims_joined(map, picture_of_thing(), 2).values, map.values);
}

}  // namespace
}  // namespace hexrelief::stages
