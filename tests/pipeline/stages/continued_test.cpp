#include "pipeline/stages/other_views/continued.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/stages/other_views/small_regions.h"

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 40, kHeight = 30;
constexpr double kNear = 60, kWall = 20;

std::uint32_t at(int x, int y) {
    return static_cast<std::uint32_t>(y * kWidth + x);
}

// A near thing everywhere, behind which a wall continues in some columns, in the colours of the first one.
struct BehindThing {
    ViewPlace place;
    Disparities front;
    Continued continued{kWidth * kHeight};

    BehindThing(int first, int end) : front(kWidth * kHeight) {
        place.width = kWidth;
        place.height = kHeight;
        std::fill(front.begin(), front.end(), kNear);
        std::fill(continued.disparities.begin(), continued.disparities.end(), kNotCovered);
        for (int y = 0; y < kHeight; ++y)
            for (int x = first; x < end; ++x) {
                continued.offer(at(x, y), kWall, x - first + 1, at(first, y));
                continued.pixels.push_back(at(x, y));
            }
    }
    void give() { give_scraps_away(continued, front, place, 10); }
};

TEST(Continued, ThingsRimDoesNotContinueBehindIt) {
    BehindThing scene(5, 20);
    for (int x = 5; x < 20; ++x) scene.continued.disparities[at(x, 12)] = kNear - 3;
    scene.give();
    for (int x = 5; x < 20; ++x) {
        EXPECT_EQ(scene.continued.disparities[at(x, 12)], kWall);
        EXPECT_NE(scene.continued.colours_of[at(x, 12)], at(5, 12)) << "the colours of the wall beside it";
    }
    EXPECT_EQ(scene.continued.pixels.size(), 15u * kHeight);
}

TEST(Continued, SlantedSurfaceStays) {
    BehindThing scene(5, 20);
    for (const std::uint32_t i : scene.continued.pixels)
        scene.continued.disparities[i] = kWall + 0.5 * static_cast<double>(i / kWidth);
    const std::vector<double> before(scene.continued.disparities.begin(), scene.continued.disparities.end());
    scene.give();
    EXPECT_TRUE(std::equal(before.begin(), before.end(), scene.continued.disparities.begin()));
}

TEST(Continued, WhatHasNoColourGetsThatOfWhatIsBesideItOrGoes) {
    BehindThing scene(5, 20);
    scene.continued.colours_of[at(7, 3)] = Continued::kNoColour;
    scene.continued.offer(at(30, 3), kWall, 1, Continued::kNoColour);
    scene.continued.pixels.push_back(at(30, 3));
    scene.give();
    EXPECT_NE(scene.continued.colours_of[at(7, 3)], Continued::kNoColour);
    EXPECT_EQ(scene.continued.disparities[at(30, 3)], kNotCovered);
    EXPECT_EQ(scene.continued.pixels.size(), 15u * kHeight);
}

// Far from a silhouette a colour is a mean of hundreds of pixels.
TEST(Continued, MeansOfManyBrightPixelsAreBright) {
    BehindThing scene(0, kWidth);
    for (const std::uint32_t i : scene.continued.pixels) {
        scene.continued.distances[i] = 400;
        scene.continued.colours_of[i] = i;
    }
    ThreadPool pool(2);
    Image picture{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 250)};
    paint(picture, picture, scene.place, scene.continued, pool);
    EXPECT_EQ(std::count(picture.pixels.begin(), picture.pixels.end(), 250), kWidth * kHeight);
}

TEST(Continued, ColoursAreTakenFromAnotherPicture) {
    BehindThing scene(5, 20);
    Image picture{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 10)};
    const Image seen{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 70)};
    ThreadPool pool(2);
    paint(picture, seen, scene.place, scene.continued, pool);
    EXPECT_EQ(std::count(picture.pixels.begin(), picture.pixels.end(), 70), 15 * kHeight);
}

TEST(Continued, ColoursSpreadAsFarAsAskedOverWhatHidesThem) {
    for (const int spread_px : {3, 8}) {
        BehindThing scene(5, 20);
        DisparityMap missing{kWidth, kHeight, std::vector<float>(kWidth * kHeight, kUnknownDisparity)};
        spread_colours(scene.continued, missing, scene.front, spread_px);
        EXPECT_EQ(scene.continued.colours_of[at(19 + spread_px, 9)], at(5, 9));
        EXPECT_EQ(scene.continued.disparities[at(20 + spread_px, 9)], kNotCovered);
    }
}

TEST(Continued, SmallRegionIsACrackOfTheSurfaceThatItGoesOnWith) {
    DisparityMap map{kWidth, kHeight, std::vector<float>(kWidth * kHeight, kUnknownDisparity)};
    Disparities surface(map.values.size());
    std::fill(surface.begin(), surface.end(), kNear);
    for (int y = 5; y < 10; ++y)
        for (const int x : {10, 30}) {
            map.at(x, y) = static_cast<float>(x == 10 ? kNear - 0.5 : kWall);
            surface[at(x, y)] = kNotCovered;
        }
    const std::vector<std::uint32_t> cracks = cracks_of(map, surface);
    EXPECT_EQ(cracks.size(), 5u);
    EXPECT_TRUE(std::ranges::all_of(cracks, [](std::uint32_t i) { return i % kWidth == 10; }));
}

}  // namespace
}  // namespace hexrelief::stages
