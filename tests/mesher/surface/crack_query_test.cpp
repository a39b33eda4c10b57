// Tests the crossings of edges with silhouettes, from either end.
#include "mesher/surface/pixels/edge_crossings_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "mesher/surface/pixels/crack_query.h"
#include "mesher/surface/pixels/eight_flags.h"
#include "mesher/surface/pixels/pixel_surfaces.h"

namespace hexrelief::surface {
namespace {

// Returns a board of fields 7 px wide and up to 60 px high, each at its own depth.
DisparityMap board(int width, int height, std::mt19937& random) {
    DisparityMap map;
    map.width = width;
    map.height = height;
    std::vector<float> depths(static_cast<std::size_t>(width / 7 + 1) * (height / 7 + 1));
    for (float& d : depths) d = static_cast<float>(20 + 10 * (random() % 5));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            map.values.push_back(depths[static_cast<std::size_t>(y / 7) * (width / 7 + 1) + x / 7]);
    return map;
}

// Returns the discontinuities on the steps of a path from pixel to pixel, sideways before up or down.
std::vector<step::Crack> naive_discontinuities(const step::PixelView& view, const step::Way& way) {
    std::vector<step::Crack> discontinuities;
    const auto look = [&](const step::Crack& c) {
        if (view.flags[view.index(c.x, c.y)] &
            (c.down ? step::kDiscontinuityDown : step::kDiscontinuityRight))
            discontinuities.push_back(c);
    };
    for (int k = 1; k <= way.steps; ++k) {
        const step::Pixel from = step::pixel_after(view, way, k - 1), to = step::pixel_after(view, way, k);
        if (from.x != to.x) look({std::min(from.x, to.x), from.y, 0});
        if (from.y != to.y) look({to.x, std::min(from.y, to.y), 1});
    }
    return discontinuities;
}

TEST(CrackEdges, AreVisitedInOrderEightPixelsAtATime) {
    std::mt19937 random(6);
    const DisparityMap map = board(61, 40, random);
    ThreadPool pool(1);
    const PixelSurfaces surfaces = find_pixel_surfaces(map, 0, 36, {}, pool);
    const step::PixelView view = surfaces.view();
    std::size_t seen = 0;
    for (int i = 0; i < 2000; ++i) {
        const int y = static_cast<int>(random() % 40), a = static_cast<int>(random() % 62),
                  b = static_cast<int>(random() % 62);
        std::vector<step::Crack> expected, found;
        for (int x = std::min(a, b); x < std::max(a, b); ++x)
            for (int down = 0; down < 2; ++down)
                if (step::is_crack(view, {x, y, down})) expected.push_back({x, y, down});
        each_crack(view, y, std::min(a, b), std::max(a, b),
                   [&](const step::Crack& c) { found.push_back(c); });
        ASSERT_TRUE(found == expected) << y << ": " << a << ", " << b;
        seen += found.size();
    }
    EXPECT_GT(seen, 1000u);
}

TEST(Crossings, BothEndsOfAnEdgeSeeTheSameDiscontinuities) {
    std::mt19937 random(5);
    const DisparityMap map = board(90, 61, random);
    ThreadPool pool(1);
    const PixelSurfaces surfaces = find_pixel_surfaces(map, 0, 36, {}, pool);
    const CrackQuery look{surfaces.view(), surfaces.tiles()};
    std::uniform_real_distribution<float> x(0, 90), y(0, 61), way(-14, 14);
    int one = 0, several = 0, none = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec2f a{x(random), y(random)};
        const Vec2f b{std::clamp(a.x + way(random), 0.0f, 90.0f), std::clamp(a.y + way(random), 0.0f, 61.0f)};
        if (step::distance(a, b) < 0.5f) continue;
        const std::vector<step::Crack> discontinuities =
            naive_discontinuities(look.pixels, step::way_between(a.x, a.y, b.x, b.y));
        const float from_a = step::open_crossing(look, a, false, b, false, true),
                    from_b = step::open_crossing(look, b, false, a, false, false);
        EXPECT_EQ(from_a >= 0, !discontinuities.empty());
        EXPECT_EQ(from_b >= 0, !discontinuities.empty());
        ++(discontinuities.empty() ? none : discontinuities.size() == 1 ? one : several);
        if (discontinuities.empty()) continue;
        EXPECT_EQ(look.walk(a, b, false).discontinuity, discontinuities.front());
        EXPECT_EQ(look.walk(a, b, true).discontinuity, discontinuities.back());
        EXPECT_EQ(from_a, step::meet(look.silhouette_point(discontinuities.front()), a.x, a.y, b.x, b.y));
        EXPECT_EQ(from_b, step::meet(look.silhouette_point(discontinuities.back()), b.x, b.y, a.x, a.y));
        if (discontinuities.size() == 1) {
            EXPECT_NEAR(from_a + from_b, 1, 1e-4);
        }
        // from a silhouette, the farthest counts
        const float beyond = step::open_crossing(look, a, true, b, false, true),
                    farthest = step::meet(look.silhouette_point(discontinuities.back()), a.x, a.y, b.x, b.y);
        EXPECT_TRUE(beyond == farthest || beyond == -1);
    }
    EXPECT_GT(none, 1000);
    EXPECT_GT(one, 1000);
    EXPECT_GT(several, 1000);
}

}  // namespace
}  // namespace hexrelief::surface
