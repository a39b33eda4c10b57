// Tests that surfaces go on beyond the right picture's end.
#include "pipeline/stages/dequantize/bare_patches.h"

#include <gtest/gtest.h>

namespace hexrelief::stages {
namespace {

constexpr int kStripColumns = 120, kStripRows = 4, kSeenColumns = 80;  // columns that the right picture shows
constexpr float kSky = 10, kHedge = 30, kPole = 40;

// A bare sky that matched as far as the right picture shows it, and was filled from a hedge farther right.
struct Sky {
    DisparityMap map{kStripColumns, kStripRows, {}, {}};
    std::vector<std::uint8_t> is_seen;

    Sky() {
        for (int y = 0; y < kStripRows; ++y)
            for (int x = 0; x < kStripColumns; ++x) {
                const bool is_matched = static_cast<float>(x) - kSky < kSeenColumns;
                map.values.push_back(is_matched ? kSky : kHedge);
                map.origins.push_back(is_matched ? PixelOrigin::matched : PixelOrigin::filled);
                is_seen.push_back(x < kSeenColumns);
            }
    }
    void put_pole(int y, int first, int end) {
        for (int x = first; x < end; ++x) {
            map.at(x, y) = kPole;
            map.origins[static_cast<std::size_t>(y) * kStripColumns + x] = PixelOrigin::matched;
        }
    }
};

TEST(RightStrip, ContinuesWhatLeavesTheRightPicture) {
    const Sky sky;
    const DisparityMap result = continued_at_right_end(sky.map, sky.is_seen);
    for (const float d : result.values) EXPECT_EQ(d, kSky);
    EXPECT_EQ(result.origins, sky.map.origins);
    EXPECT_EQ(continued_at_right_end(sky.map, {}).values, sky.map.values) << "all of it is seen";
}

TEST(RightStrip, KeepsWhatMatchedBesideEachOther) {
    Sky sky;
    sky.put_pole(1, 100, 104);  // a 60th of the longer side is 2 px
    sky.put_pole(2, 100, 101);  // a chance match
    const DisparityMap result = continued_at_right_end(sky.map, sky.is_seen);
    EXPECT_EQ(result.at(99, 1), kSky);
    EXPECT_EQ(result.at(100, 1), kPole);
    EXPECT_EQ(result.at(103, 1), kPole);
    EXPECT_EQ(result.at(104, 1), kHedge) << "the pole itself lies inside the right picture";
    EXPECT_EQ(result.at(100, 2), kSky);
}

TEST(RightStrip, NothingGoesOnOverUnknownPixels) {
    Sky sky;
    sky.map.at(95, 0) = kUnknownDisparity;
    const DisparityMap result = continued_at_right_end(sky.map, sky.is_seen);
    EXPECT_EQ(result.at(94, 0), kSky);
    EXPECT_FALSE(DisparityMap::known(result.at(95, 0)));
    EXPECT_EQ(result.at(96, 0), kHedge);
}

}  // namespace
}  // namespace hexrelief::stages
