#include "pipeline/matching/matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <vector>

namespace hexrelief::matching {
namespace {

constexpr int kWidth = 240, kHeight = 120;
constexpr std::uint8_t kGrey = 120;

struct Scene {
    std::vector<int> truth;  // 1/16 px
    MatchedMap map;
    Image left;
};

std::size_t index(int x, int y) {
    return static_cast<std::size_t>(y) * kWidth + x;
}

// disparity(x, y) is in px. Pixels that the right camera does not see are filled, row by row, with the match
// to their right.
Scene scene_of(
    const std::function<float(int, int)>& disparity,
    const std::function<bool(int, int)>& is_black = [](int, int) { return false; }) {
    const std::size_t count = index(0, kHeight);
    Scene scene{std::vector<int>(count),
                {kWidth, kHeight, std::vector<std::int16_t>(count), std::vector<std::uint8_t>(count, 1)},
                {kWidth, kHeight, 3, std::vector<std::uint8_t>(3 * count, kGrey)}};
    for (int y = 0; y < kHeight; ++y) {
        int match = 0, leftmost = kOnePixel * kWidth;  // in the right picture
        for (int x = kWidth - 1; x >= 0; --x) {
            const int d = static_cast<int>(std::lround(kOnePixel * disparity(x, y)));
            const int in_right = kOnePixel * x - d;
            scene.truth[index(x, y)] = d;
            if (is_black(x, y)) std::fill_n(scene.left.at(x, y), 3, std::uint8_t{0});
            const bool is_seen = in_right >= 0 && in_right < leftmost;
            if (is_seen) match = d, leftmost = in_right;
            scene.map.disparities[index(x, y)] = static_cast<std::int16_t>(match);
            scene.map.is_matched[index(x, y)] = is_seen;
        }
    }
    return scene;
}

MatchedMap continued(const Scene& scene) {
    MatchedMap map = scene.map;
    continue_into_strip(map, scene.left, 0);
    return map;
}

int error(const Scene& scene, const MatchedMap& map, int x, int y) {
    return std::abs(map.disparities[index(x, y)] - scene.truth[index(x, y)]);
}

// A wall that recedes to the left.
float slanted(int x, int y) {
    return 20 + 0.1f * static_cast<float>(x) + 0.05f * static_cast<float>(y);
}

TEST(UnseenStrip, SlantedWallGoesOn) {
    // The few rows of floor have less than the wall's disparities.
    const Scene scene = scene_of([](int x, int y) { return y < 110 ? slanted(x, y) : 15.0f; });
    ASSERT_GT(error(scene, scene.map, 0, 60), kOnePixel);
    const MatchedMap map = continued(scene);
    for (int y = 0; y < 75; ++y)
        for (int x = 0; x < kWidth; ++x) ASSERT_LE(error(scene, map, x, y), kOnePixel / 4) << x << ' ' << y;
}

TEST(UnseenStrip, DisparitiesCountFromTheLeast) {
    Scene scene = scene_of([](int x, int y) { return y < 110 ? slanted(x, y) : 15.0f; });
    const MatchedMap from_zero = continued(scene);
    constexpr int kMin_px = 10;
    for (std::int16_t& d : scene.map.disparities) d -= kMin_px * kOnePixel;
    continue_into_strip(scene.map, scene.left, kMin_px);
    for (std::size_t i = 0; i < scene.map.disparities.size(); ++i)
        ASSERT_EQ(scene.map.disparities[i] + kMin_px * kOnePixel, from_zero.disparities[i]);
}

TEST(UnseenStrip, OnlyFilledPixelsOfTheStripChange) {
    Scene scene = scene_of(slanted);
    const std::size_t hole = index(120, 50), unknown = index(5, 0);
    scene.map.disparities[hole] = 999;
    scene.map.disparities[unknown] = kUnknown16;
    scene.map.is_matched[hole] = 0;
    const MatchedMap map = continued(scene);
    EXPECT_EQ(map.is_matched, scene.map.is_matched);
    EXPECT_EQ(map.disparities[hole], 999);
    EXPECT_EQ(map.disparities[unknown], kUnknown16);
    for (std::size_t i = 0; i < map.disparities.size(); ++i)
        ASSERT_TRUE(!map.is_matched[i] || map.disparities[i] == scene.map.disparities[i]);
    EXPECT_NE(map.disparities, scene.map.disparities);
}

// A black thing stands at the strip's end. Left of it the wall is seen, grey as above and below.
TEST(UnseenStrip, ColorsTellTheSurface) {
    const auto is_thing = [](int x, int y) { return x >= 40 && x < 90 && y >= 40 && y < 80; };
    const Scene scene = scene_of([&](int x, int y) { return is_thing(x, y) ? 50.0f : 20.0f; }, is_thing);
    ASSERT_EQ(scene.map.disparities[index(20, 60)], 50 * kOnePixel);
    const MatchedMap map = continued(scene);
    for (int y = 45; y < 75; ++y)  // colours are averaged
        for (const int x : {0, 10, 20, 30, 36, 43, 49})
            ASSERT_EQ(error(scene, map, x, y), 0) << x << ' ' << y;
}

// A black thing stands wholly beyond the right picture's edge, where filling has put it near.
TEST(UnseenStrip, ThingWithoutMatchesKeepsItsDistance) {
    const auto is_thing = [](int x, int y) { return x < 14 && y >= 30 && y < 90; };
    Scene scene = scene_of([](int, int y) { return y < 100 ? 30.0f : 60.0f; }, is_thing);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < 14; ++x)
            if (is_thing(x, y)) scene.map.disparities[index(x, y)] = 50 * kOnePixel;
    const MatchedMap map = continued(scene);
    for (int y = 40; y < 80; ++y) {
        ASSERT_EQ(map.disparities[index(5, y)], 50 * kOnePixel) << y;
        ASSERT_EQ(map.disparities[index(25, y)], 30 * kOnePixel) << y;
    }
}

// A surface that levels off where the strip begins; a near thing keeps the largest disparity away.
TEST(UnseenStrip, BentSurfaceIsNotFollowedFar) {
    const Scene scene = scene_of([](int x, int y) {
        const float from_end = static_cast<float>(std::max(0, x - 40));
        return x > 200 && y > 110 ? 100 : std::max(10.0f, 40 - from_end * from_end / 150);
    });
    const MatchedMap map = continued(scene);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < 40; ++x) ASSERT_LE(error(scene, map, x, y), kOnePixel * 9 / 8) << x << ' ' << y;
}

TEST(UnseenStrip, DisparitiesStayAmongTheMatched) {
    const Scene scene = scene_of([](int x, int) { return 60 - 0.3f * static_cast<float>(x); });
    int largest = 0;
    for (std::size_t i = 0; i < scene.truth.size(); ++i)
        if (scene.map.is_matched[i]) largest = std::max<int>(largest, scene.map.disparities[i]);
    const MatchedMap map = continued(scene);
    EXPECT_EQ(*std::max_element(map.disparities.begin(), map.disparities.end()), largest);
}

TEST(UnseenStrip, NothingHappensWithoutMatchesOrStrip) {
    Scene scene = scene_of([](int, int) { return 0.0f; });
    EXPECT_EQ(continued(scene).disparities, scene.map.disparities);
    std::fill(scene.map.is_matched.begin(), scene.map.is_matched.end(), std::uint8_t{0});
    EXPECT_EQ(continued(scene).disparities, scene.map.disparities);
}

TEST(UnseenStrip, OneRowOfGreyIsEnough) {
    for (const int width : {40, 1400}) {
        const auto count = static_cast<std::size_t>(width);
        const std::vector<std::int16_t> wall(count, 8 * kOnePixel);
        MatchedMap map{width, 1, wall, std::vector<std::uint8_t>(count, 1)};
        std::fill_n(map.is_matched.begin(), 8, std::uint8_t{0});
        std::fill_n(map.disparities.begin(), 8, std::int16_t{3 * kOnePixel});
        continue_into_strip(map, {width, 1, 1, std::vector<std::uint8_t>(count, kGrey)}, 0);
        EXPECT_EQ(map.disparities, wall);
    }
}

}  // namespace
}  // namespace hexrelief::matching
