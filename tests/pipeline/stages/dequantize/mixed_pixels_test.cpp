// Tests that pixels between two surfaces are given to one of these.
#include "pipeline/stages/dequantize/mixed_pixels.h"

#include <gtest/gtest.h>

namespace hexrelief::stages {
namespace {

// A near surface on the left of column 6, a far one on the right of column 7, and two mixed columns.
DisparityMap two_surfaces() {
    DisparityMap map{14, 10, {}};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            map.values.push_back(x < 6 ? 20.0f : x < 7 ? 16.0f : x < 8 ? 12.0f : 5.0f);
    return map;
}

Image picture_of(const DisparityMap& map) {
    Image left{map.width, map.height, 1, {}};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) left.pixels.push_back(x < 7 ? 200 : 50);
    return left;
}

TEST(MixedPixels, FollowTheSurfaceOfTheirColour) {
    const DisparityMap map = two_surfaces();
    const DisparityMap result = without_mixed_pixels(map, picture_of(map));
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            EXPECT_EQ(result.at(x, y), x < 7 ? 20.0f : 5.0f) << x << ", " << y;
}

TEST(MixedPixels, ThinThingsInFrontAndUnknownPixelsStay) {
    DisparityMap map{14, 10, std::vector<float>(140, 5.0f)};
    for (int y = 0; y < map.height; ++y) map.at(6, y) = 12.0f;
    map.at(2, 2) = kUnknownDisparity;
    EXPECT_EQ(without_mixed_pixels(map, picture_of(map)).values, map.values);
}

}  // namespace
}  // namespace hexrelief::stages
