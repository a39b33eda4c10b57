#include "pipeline/stages/other_views/continued.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/stages/other_views/behind_silhouettes.h"
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
    void give() {
        ThreadPool pool(2);
        give_scraps_away(continued, front, place, 10, pool);
    }
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

TEST(Continued, WhatIsInFrontWithoutAColourGetsThatOfWhatIsInFrontBesideIt) {
    BehindThing scene(5, 20);
    for (int y = 3; y < 7; ++y) {
        scene.continued.offer(at(25, y), kNear, 0, y == 3 ? at(28, y) : Continued::kNoColour);
        scene.continued.pixels.push_back(at(25, y));
    }
    // A colour goes before none, whichever is offered first.
    scene.continued.offer(at(25, 6), kNear, 0, at(29, 6));
    scene.continued.offer(at(25, 3), kNear, 0, Continued::kNoColour);
    scene.give();
    EXPECT_EQ(scene.continued.colours_of[at(25, 4)], at(28, 3));
    EXPECT_EQ(scene.continued.colours_of[at(25, 5)], at(29, 6));
    EXPECT_EQ(scene.continued.colours_of[at(25, 3)], at(28, 3));
    EXPECT_EQ(scene.continued.disparities[at(25, 5)], kNear);
    EXPECT_EQ(scene.continued.distances[at(25, 5)], 0);
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

TEST(Continued, ColoursSpreadOverWhatIsOpen) {
    BehindThing scene(5, 20);
    scene.front[at(21, 9)] = kNotCovered;
    const DisparityMap missing{kWidth, kHeight, std::vector<float>(kWidth * kHeight, kUnknownDisparity)};
    spread_colours(scene.continued, missing, scene.front, 3);
    EXPECT_EQ(scene.continued.colours_of[at(21, 9)], at(5, 9));
}

// A near thing before a wall, over whose edge its colours reach by 4 px, and by one that is mixed. In some
// rows the wall is but a crack of the thing, in some the marks of another silhouette leave it no clean
// colour.
TEST(Continued, MixedPixelsBesideAThingAreCleanInEachRow) {
    constexpr int kEdge = 40, kSide = 100, kRows = 60;
    const auto is_crack = [](int y) { return y >= 10 && y < 14; };
    const auto disparity_at = [&](int x, int y) {
        if (x < kEdge || (is_crack(y) && x >= kEdge + 3 && x < kEdge + 15)) return 80.0;
        return y < kRows / 2 ? 20.0 : 30.0;
    };
    // From the edge on. The last is the wall's own, so that the line is no outline.
    constexpr std::array<std::uint8_t, 8> kColours = {220, 220, 220, 220, 150, 100, 100, 190};
    OtherView view;
    view.place = {0, 0, 0, 1, kSide, kRows};
    view.missing = {kSide, kRows, std::vector<float>(kSide * kRows, kUnknownDisparity)};
    view.color = {kSide, kRows, 1, std::vector<std::uint8_t>(kSide * kRows, 100)};
    SeenSurface here;
    here.place = view.place;
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kSide; ++x) {
            here.disparities.push_back(disparity_at(x, y));
            if (disparity_at(x, y) == 80)
                *view.color.at(x, y) = 220;
            else if (x - kEdge < 8)
                *view.color.at(x, y) = kColours[x - kEdge];
        }
    paint_behind(
        view,
        continue_behind(view, here, {.right = 1, .mixed_px = Beyond::kMixedOfPhotographs_px}, {{here}, 1}, 2),
        nullptr, 2);
    for (int y = 2; y < kRows - 2; ++y)
        for (int x = kEdge; x < kEdge + (is_crack(y) ? 3 : 6); ++x)
            EXPECT_LT(*view.color.at(x, y), 112) << x << ' ' << y;
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

// A map of 20 px left of column 15 and above row 5, of 14 px elsewhere; row 15 is unknown.
DisparityMap map_with_steps() {
    DisparityMap map{kWidth, kHeight, std::vector<float>(kWidth * kHeight, 14)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            if (y == 15)
                map.at(x, y) = kUnknownDisparity;
            else if (x < 15 || y < 5)
                map.at(x, y) = 20;
    return map;
}

TEST(Continued, LowStepsOfWhatNoCameraShowsBecomeRamps) {
    DisparityMap map = map_with_steps();
    std::vector<std::uint8_t> is_shown(map.values.size());
    is_shown[at(14, 10)] = is_shown[at(20, 4)] = 1;
    ramp_steps(map, is_shown, 6);
    for (int k = 1; k <= 6; ++k) EXPECT_NEAR(map.at(15 - k, 12), 14 + 0.9 * k, 1e-5) << k;
    for (int k = 1; k < 5; ++k) EXPECT_NEAR(map.at(25, 5 - k), 14 + 0.9 * k, 1e-5) << k;
    for (int x = 0; x < 8; ++x) EXPECT_EQ(map.at(x, 12), 20) << "far from the step at " << x;
    for (int x = 15; x < kWidth; ++x) EXPECT_EQ(map.at(x, 12), 14) << "what lies behind stays at " << x;
    EXPECT_EQ(map.at(14, 10), 20) << "a camera shows it";
    EXPECT_EQ(map.at(20, 4), 20) << "a camera shows it";
    for (int x = 0; x < kWidth; ++x) EXPECT_EQ(map.at(x, 15), kUnknownDisparity);
}

TEST(Continued, RampsLeadUpFromAllSides) {
    const std::vector<std::uint8_t> none_shown(kWidth * kHeight);
    DisparityMap map = map_with_steps(), turned = map;
    std::ranges::reverse(turned.values);
    ramp_steps(map, none_shown, 6);
    ramp_steps(turned, none_shown, 6);
    std::ranges::reverse(turned.values);
    EXPECT_EQ(turned.values, map.values);
}

TEST(Continued, HigherStepsStay) {
    DisparityMap map = map_with_steps();
    ramp_steps(map, std::vector<std::uint8_t>(map.values.size()), 5.9);
    EXPECT_EQ(map.values, map_with_steps().values);
}

TEST(Continued, OnlyKnownPixelsCountAsShown) {
    const std::vector<std::uint8_t> known = known_pixels(map_with_steps());
    for (int y = 0; y < kHeight; ++y) EXPECT_EQ(known[at(7, y)], y == 15 ? 0 : 1) << y;
}

}  // namespace
}  // namespace hexrelief::stages
