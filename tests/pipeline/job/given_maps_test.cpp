#include "pipeline/job/matchers/given_maps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace hexrelief::job {
namespace {

constexpr int kColumns = 200, kRows = 120, kWall_px = 8, kSquare_px = 24;

// A square in front of a wall, both with a texture, and what a perfect matcher knows of it.
struct Scene {
    StereoPair pair;
    stages::ViewMaps maps{{}, {}, true};
};

bool is_square(int x, int y) {
    return x >= 80 && x < 130 && y >= 35 && y < 85;
}

int noise(int x, int y, int c, int seed) {
    auto h = static_cast<std::uint32_t>(x) * 73856093U ^ static_cast<std::uint32_t>(y) * 19349663U ^
             static_cast<std::uint32_t>(3 * c + seed) * 83492791U;
    h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
    return static_cast<int>((h >> 16) & 0x3f);
}

// Blotches of 2x2 px, so that matches of half a pixel are alike.
int level(int x, int y, int c, bool near) {
    return (near ? 150 : 40) + noise(x >> 1, y >> 1, c, near ? 5 : 0);
}

Scene make_scene() {
    Scene scene;
    for (Image* const image : {&scene.pair.left, &scene.pair.right}) *image = {kColumns, kRows, 3, {}};
    for (DisparityMap* const map : {&scene.maps.left, &scene.maps.right}) *map = {kColumns, kRows, {}};
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) {
            const bool left = is_square(x, y), right = is_square(x + kSquare_px, y);
            scene.maps.left.values.push_back(left ? kSquare_px : kWall_px);
            scene.maps.right.values.push_back(right ? kSquare_px : kWall_px);
            for (int c = 0; c < 3; ++c) {
                scene.pair.left.pixels.push_back(static_cast<std::uint8_t>(level(x, y, c, left)));
                scene.pair.right.pixels.push_back(
                    static_cast<std::uint8_t>(level(right ? x + kSquare_px : x + kWall_px, y, c, right)));
            }
        }
    return scene;
}

// Replaces each disparity by the mean, or the largest, of those within `reach` px.
DisparityMap changed(const DisparityMap& map, int reach, bool to_largest) {
    DisparityMap result = map;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            float sum = 0, largest = 0;
            int count = 0;
            for (int v = std::max(0, y - reach); v <= std::min(map.height - 1, y + reach); ++v)
                for (int u = std::max(0, x - reach); u <= std::min(map.width - 1, x + reach); ++u, ++count)
                    sum += map.at(u, v), largest = std::max(largest, map.at(u, v));
            result.at(x, y) = to_largest ? largest : sum / static_cast<float>(count);
        }
    return result;
}

// Returns the share of the pixels that are more than 2 px off, in percent.
double bad2(const DisparityMap& map) {
    int bad = 0;
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x)
            bad +=
                !(std::abs(map.at(x, y) - static_cast<float>(is_square(x, y) ? kSquare_px : kWall_px)) <= 2);
    return 100.0 * bad / (kColumns * kRows);
}

DisparityMap refined(const Scene& scene) {
    return refine_given(scene.pair, scene.maps, {}, 2);
}

TEST(GivenMaps, ATrueMapStaysAsItIs) {
    const Scene scene = make_scene();
    const DisparityMap map = refined(scene);
    EXPECT_EQ(map.values, scene.maps.left.values);
    // Also what the right camera does not see, which is not matched.
    EXPECT_EQ(map.origins[60 * kColumns + 70], PixelOrigin::filled);
    EXPECT_EQ(map.origins[60 * kColumns + 100], PixelOrigin::matched);
    EXPECT_EQ(map.origins[5], PixelOrigin::filled);
}

TEST(GivenMaps, BlurredAndDisplacedStepsAreCutByTheColours) {
    for (const bool to_largest : {false, true}) {
        Scene scene = make_scene();
        scene.maps.left = changed(scene.maps.left, 4, to_largest);
        scene.maps.right = changed(scene.maps.right, 4, to_largest);
        const double before = bad2(scene.maps.left), after = bad2(refined(scene));
        EXPECT_GT(before, 3.5) << to_largest;
        EXPECT_LT(after, before / 2) << to_largest;
    }
}

TEST(GivenMaps, AnOffsetGetsNoWorse) {
    Scene scene = make_scene();
    for (DisparityMap* const map : {&scene.maps.left, &scene.maps.right})
        for (float& d : map->values) d += 0.75F;
    EXPECT_EQ(bad2(scene.maps.left), 0);
    EXPECT_EQ(bad2(refined(scene)), 0);
}

TEST(GivenMaps, WhatTheRightViewAndTheColoursContradictIsReplaced) {
    Scene scene = make_scene();
    // A patch of the wall that seems near, which would hide what the right camera sees.
    for (int y = 90; y < 115; ++y)
        for (int x = 150; x < 180; ++x) scene.maps.left.at(x, y) = 40;
    EXPECT_GT(bad2(scene.maps.left), 3);
    EXPECT_LT(bad2(refined(scene)), 0.3);
}

TEST(GivenMaps, MapsWithHolesAreRefinedAsBefore) {
    Scene scene = make_scene();
    scene.maps.is_dense = false;
    for (float& d : scene.maps.left.values) d += 0.3F;
    const DisparityMap map = refined(scene);
    EXPECT_NE(map.values, scene.maps.left.values);
    for (const float d : map.values) EXPECT_EQ(d * 16, std::floor(d * 16));
}

TEST(GivenMaps, TheRightPictureAloneChecksAMap) {
    for (const bool to_largest : {false, true}) {
        const Scene scene = make_scene();
        const DisparityMap faulty = changed(scene.maps.left, 4, to_largest);
        const PictureCheck check = check_by_picture(scene.pair, faulty, {}, 2);
        EXPECT_GT(check.unlike_share, 0.02) << to_largest;
        EXPECT_LT(bad2(check.map), bad2(faulty) / 2) << to_largest;
        const PictureCheck of_true = check_by_picture(scene.pair, scene.maps.left, {}, 2);
        EXPECT_LT(of_true.unlike_share, 0.005);
        EXPECT_EQ(of_true.map.values, scene.maps.left.values);
    }
}

TEST(GivenMaps, APatchOfAnotherColourIsFilled) {
    const Scene scene = make_scene();
    DisparityMap map = scene.maps.left;
    for (int y = 90; y < 115; ++y)
        for (int x = 150; x < 180; ++x) map.at(x, y) = 40;
    EXPECT_GT(bad2(map), 3);
    EXPECT_LT(bad2(check_by_picture(scene.pair, map, {}, 2).map), 0.3);
}

TEST(GivenMaps, WhatAMapDoesNotKnowStaysUnknown) {
    const Scene scene = make_scene();
    DisparityMap map = scene.maps.left;
    for (int x = 20; x < 60; ++x) map.at(x, 10) = kUnknownDisparity;
    const PictureCheck check = check_by_picture(scene.pair, map, {}, 2);
    for (int x = 20; x < 60; ++x) EXPECT_FALSE(DisparityMap::known(check.map.at(x, 10)));
}

}  // namespace
}  // namespace hexrelief::job
