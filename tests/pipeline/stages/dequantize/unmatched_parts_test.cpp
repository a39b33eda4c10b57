// Tests that large parts without matches along the rims follow the matched surfaces of their colours.
#include "pipeline/stages/dequantize/unmatched_parts.h"

#include <gtest/gtest.h>

namespace hexrelief::stages {
namespace {

constexpr int kMapWidth = 100, kMapHeight = 60, kEnd = 91,
              kSky = 30;  // columns that matched, rows of the sky
constexpr float kSky_px = 4, kLawn_px = 20;

// A sky above a lawn, matched but for the right rim, which was filled with the lawn's disparity.
struct Meadow {
    DisparityMap map{kMapWidth, kMapHeight, {}, {}};
    Image left{kMapWidth, kMapHeight, 3, {}};

    Meadow() {
        for (int y = 0; y < kMapHeight; ++y)
            for (int x = 0; x < kMapWidth; ++x) {
                map.values.push_back(x < kEnd && y < kSky ? kSky_px : kLawn_px);
                map.origins.push_back(x < kEnd ? PixelOrigin::matched : PixelOrigin::filled);
                for (int c = 0; c < 3; ++c) left.pixels.push_back(y < kSky ? 220 : 60);
            }
    }
};

TEST(UnmatchedParts, FollowTheFartherSurfaceOfTheirColours) {
    const Meadow meadow;
    const DisparityMap result = with_unmatched_parts_continued(meadow.map, meadow.left, 2);
    for (int y = 0; y < kMapHeight; ++y)
        for (int x = 0; x < kMapWidth; ++x) {
            if (y >= kSky - 4 && y < kSky + 4) continue;  // colours of both
            EXPECT_NEAR(result.at(x, y), y < kSky ? kSky_px : kLawn_px, 0.1) << x << ", " << y;
        }
    EXPECT_EQ(result.origins, meadow.map.origins);
    EXPECT_EQ(result.values, with_unmatched_parts_continued(meadow.map, meadow.left, 3).values);
}

TEST(UnmatchedParts, MatchedAndUnknownPixelsAndMapsWithoutOriginsStay) {
    Meadow meadow;
    meadow.map.at(95, 5) = kUnknownDisparity;
    meadow.map.origins[96] = PixelOrigin::matched;
    const DisparityMap result = with_unmatched_parts_continued(meadow.map, meadow.left, 1);
    EXPECT_FALSE(DisparityMap::known(result.at(95, 5)));
    EXPECT_EQ(result.at(96, 0), kLawn_px);
    meadow.map.origins.clear();
    EXPECT_EQ(with_unmatched_parts_continued(meadow.map, meadow.left, 1).values, meadow.map.values);
}

}  // namespace
}  // namespace hexrelief::stages
