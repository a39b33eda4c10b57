// Tests that pixels between two surfaces are given to one of these.
#include "pipeline/stages/by_colour/mixed_pixels.h"

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
    const DisparityMap result = without_mixed_pixels(map, picture_of(map), Scraps::stay);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            EXPECT_EQ(result.at(x, y), x < 7 ? 20.0f : 5.0f) << x << ", " << y;
}

TEST(MixedPixels, ThinThingsInFrontAndUnknownPixelsStay) {
    DisparityMap map{14, 10, std::vector<float>(140, 5.0f)};
    for (int y = 0; y < map.height; ++y) map.at(6, y) = 12.0f;
    map.at(2, 2) = kUnknownDisparity;
    EXPECT_EQ(without_mixed_pixels(map, picture_of(map), Scraps::stay).values, map.values);
}

// A thing at 12 px in front of a wall at 5 px, in the columns and rows from first to last.
DisparityMap with_thing(int first_x, int last_x, int first_y, int last_y, PixelOrigin origin) {
    constexpr int kSide = 800;
    DisparityMap map{kSide, 10, std::vector<float>(kSide * 10, 5.0f),
                     std::vector<PixelOrigin>(kSide * 10, PixelOrigin::matched)};
    for (int y = first_y; y <= last_y; ++y)
        for (int x = first_x; x <= last_x; ++x) {
            map.at(x, y) = 12.0f;
            map.origins[static_cast<std::size_t>(y) * kSide + x] = origin;
        }
    return map;
}

float value_after(const DisparityMap& map, int x, int y, Scraps scraps = Scraps::stay) {
    const Image left{map.width, map.height, 1, std::vector<std::uint8_t>(map.values.size(), 90)};
    return without_mixed_pixels(map, left, scraps).at(x, y);
}

TEST(MixedPixels, ScrapsInFrontGoIfTheyWereNotMatched) {
    EXPECT_EQ(value_after(with_thing(30, 36, 2, 7, PixelOrigin::filled), 33, 4, Scraps::go), 5.0f);
    EXPECT_EQ(value_after(with_thing(30, 36, 2, 7, PixelOrigin::filled), 33, 4, Scraps::stay), 12.0f);
    EXPECT_EQ(value_after(with_thing(30, 36, 2, 7, PixelOrigin::matched), 33, 4, Scraps::go), 12.0f);
}

TEST(MixedPixels, StripsThatWereNotMatchedGoEvenIfTheyHangOnAThing) {
    for (const PixelOrigin origin : {PixelOrigin::filled, PixelOrigin::matched}) {
        DisparityMap map = with_thing(0, 600, 4, 5, origin);
        for (int y = 0; y < map.height; ++y)
            for (int x = 601; x < map.width; ++x) map.at(x, y) = 12.0f;
        EXPECT_EQ(value_after(map, 300, 4), origin == PixelOrigin::filled ? 5.0f : 12.0f);
        EXPECT_EQ(value_after(map, 700, 4), 12.0f);
    }
}

TEST(WiderNear, CoversWhatIsBesideItByAShareOfThePicture) {
    const DisparityMap map = with_thing(300, 310, 0, 9, PixelOrigin::matched),
                       wider = with_wider_near(map, 2);
    for (int x = 0; x < map.width; ++x) EXPECT_EQ(wider.at(x, 5), x >= 298 && x <= 312 ? 12 : 5) << x;
    EXPECT_EQ(wider.origins, map.origins);
}

TEST(WiderNear, LeavesSlopesAndUnknownPixels) {
    DisparityMap map{20, 3, {}};
    for (int i = 0; i < 60; ++i) map.values.push_back(5 + 0.5f * static_cast<float>(i % 20));
    map.at(7, 1) = kUnknownDisparity;
    EXPECT_EQ(with_wider_near(map, 2).values, map.values);
}

}  // namespace
}  // namespace hexrelief::stages
