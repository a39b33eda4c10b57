#include "pipeline/stages/other_views/backing.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 100, kHeight = 40;
constexpr float kBox = 20, kWall = 4;
constexpr int kBoxBegin = 40, kBoxEnd = 60;  // columns

// A view of a wall with a box in front of it in columns first to last - 1.
SeenSurface box_before_wall(int first, int last) {
    SeenSurface here{{0, 0, 0, 1, kWidth, kHeight}, Disparities(kWidth * kHeight, kWall)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = first; x < last; ++x) here.disparities[y * kWidth + x] = kBox;
    return here;
}

TEST(Backing, BehindTheBoxIsALittleFartherThanTheWallAndHasItsColour) {
    Image picture{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 50)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = kBoxBegin; x < kBoxEnd; ++x) *picture.at(x, y) = 200;
    for (const double least_px : {1.0, kWall - 0.25}) {
        const OtherView view = backing_of(box_before_wall(kBoxBegin, kBoxEnd), picture, 1, least_px, 1);
        ASSERT_EQ(view.place.scale, 1);
        for (int x = 0; x < kWidth; ++x) {
            const bool is_missing = x >= kBoxBegin - 2 && x < kBoxEnd + 2;
            const double d = least_px > 1 ? least_px : kWall - 1;
            EXPECT_EQ(view.missing.at(x, 20), is_missing ? d : kUnknownDisparity) << x;
            EXPECT_EQ(*view.color.at(x, 20), 50) << x;
        }
    }
}

TEST(Backing, MeetsTheSurfaceAtTheBorderOfTheView) {
    const OtherView view = backing_of(box_before_wall(kWidth - 20, kWidth), {}, 1, 1, 1);
    EXPECT_EQ(view.map.at(20, 20), kWall - 1);
    EXPECT_GT(view.map.at(kWidth - 1, 20), (kWall + kBox) / 2);
    for (int x = 60; x + 1 < kWidth; ++x) EXPECT_LE(view.map.at(x, 20), view.map.at(x + 1, 20)) << x;
}

TEST(Backing, OfALargeViewHas320PxAtMost) {
    const SeenSurface here{{0, 0, 0, 1, 1000, 400}, Disparities(400000, 7.0)};
    const OtherView view = backing_of(here, {}, 1, 1, 1);
    EXPECT_EQ(view.place.scale, 4);
    EXPECT_EQ(view.place.width, 250);
    for (const float d : view.missing.values) EXPECT_FALSE(DisparityMap::known(d));
}

}  // namespace
}  // namespace hexrelief::stages
