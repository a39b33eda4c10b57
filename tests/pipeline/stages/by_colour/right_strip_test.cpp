// Tests that surfaces go on beyond the right picture's end.
#include "pipeline/stages/by_colour/bare_patches.h"

#include <gtest/gtest.h>

namespace hexrelief::stages {
namespace {

constexpr int kStripColumns = 120, kStripRows = 24,
              kSeenColumns = 80;     // columns that the right picture shows
constexpr int kMatchedColumns = 84;  // the sky leaves the right picture at column 90
constexpr float kSky = 10, kHedge = 30, kPole = 25;

// A sky that matched nearly as far as the right picture shows it, and was filled from a hedge farther right.
struct Sky {
    DisparityMap map{kStripColumns, kStripRows, {}, {}};
    Image left{kStripColumns, kStripRows, 3, {}};
    std::vector<std::uint8_t> is_seen;

    Sky() {
        for (int y = 0; y < kStripRows; ++y)
            for (int x = 0; x < kStripColumns; ++x) {
                const bool is_matched = x < kMatchedColumns;
                map.values.push_back(is_matched ? kSky : kHedge);
                map.origins.push_back(is_matched ? PixelOrigin::matched : PixelOrigin::filled);
                is_seen.push_back(x < kSeenColumns);
                for (const int level : {200, 210, 220})
                    left.pixels.push_back(static_cast<std::uint8_t>(level));
            }
    }
    void match(int first_row, int end_row, int first, int end, std::uint8_t level) {
        for (int y = first_row; y < end_row; ++y)
            for (int x = first; x < end; ++x) {
                const std::size_t i = static_cast<std::size_t>(y) * kStripColumns + x;
                map.values[i] = kPole;
                map.origins[i] = PixelOrigin::matched;
                for (std::size_t c = 0; c < 3; ++c) left.pixels[3 * i + c] = level;
            }
    }
    DisparityMap continued(int threads = 2) const {
        return continued_at_right_end(map, left, is_seen, threads);
    }
};

TEST(RightStrip, ContinuesWhatLeavesTheRightPicture) {
    const Sky sky;
    const DisparityMap result = sky.continued();
    for (const float d : result.values) EXPECT_EQ(d, kSky);
    EXPECT_EQ(result.origins, sky.map.origins);
}

TEST(RightStrip, WhatLiesWellInsideTheRightPictureStays) {
    Sky sky;
    for (std::size_t i = 0; i < sky.is_seen.size(); ++i) sky.is_seen[i] = i % kStripColumns < 115;
    const DisparityMap result = sky.continued();
    EXPECT_EQ(result.at(118, 0), kHedge);
    EXPECT_EQ(result.at(119, 0), kSky) << "109 px is within a 20th of the longer side of the end at 114 px";
}

TEST(RightStrip, ARightPictureThatIsSeenWholeEndsAtItsWidth) {
    Sky sky;
    sky.is_seen.clear();
    for (float& d : sky.map.values) d -= 8;
    const DisparityMap result = sky.continued();
    EXPECT_EQ(result.at(115, 0), kHedge - 8);
    EXPECT_EQ(result.at(116, 0), kSky - 8)
        << "114 px is within a 20th of the longer side of the end at 119 px";
}

TEST(RightStrip, AnyNumberOfThreadsAndMapsOfARow) {
    Sky sky;
    EXPECT_EQ(sky.continued(1).values, sky.continued(7).values);
    sky.map.height = sky.left.height = 1;
    sky.map.values.resize(kStripColumns);
    sky.map.origins.resize(kStripColumns);
    sky.left.pixels.resize(std::size_t{3} * kStripColumns);
    sky.is_seen.resize(kStripColumns);
    EXPECT_EQ(sky.continued(7).at(kStripColumns - 1, 0), kSky);
}

TEST(RightStrip, SurfacesAreToldApartByColour) {
    Sky sky;
    sky.match(8, 16, 92, 100, 30);
    const DisparityMap result = sky.continued();
    EXPECT_EQ(result.at(90, 12), kHedge) << "left of what matched last";
    for (int x = 92; x < 100; ++x) EXPECT_EQ(result.at(x, 12), kPole);
    EXPECT_EQ(result.at(104, 12), kSky) << "by way of the rows above";
    EXPECT_EQ(result.at(104, 2), kSky);
}

TEST(RightStrip, ChanceMatchesAreNoSurfaces) {
    Sky sky;
    sky.match(12, 13, 100, 101, 200);
    EXPECT_EQ(sky.continued().at(100, 12), kSky);
}

TEST(RightStrip, ColoursThatLeadFarDoNotBringWhatIsNearerThanTheFilledPixelsInside) {
    Sky sky;
    constexpr float kHill = 4;
    for (std::size_t i = 0; i < sky.is_seen.size(); ++i) {
        sky.is_seen[i] = i % kStripColumns < 110;
        if (sky.map.values[i] == kHedge) sky.map.values[i] = kHill;
    }
    EXPECT_EQ(sky.continued().at(117, 0), kHill) << "the sky matched 34 px away";
}

TEST(RightStrip, NothingGoesOnOverUnknownPixels) {
    Sky sky;
    for (int y = 0; y < kStripRows; ++y) sky.map.at(95, y) = kUnknownDisparity;
    const DisparityMap result = sky.continued();
    EXPECT_EQ(result.at(94, 0), kSky);
    EXPECT_FALSE(DisparityMap::known(result.at(95, 0)));
    EXPECT_EQ(result.at(96, 0), kHedge);
}

}  // namespace
}  // namespace hexrelief::stages
