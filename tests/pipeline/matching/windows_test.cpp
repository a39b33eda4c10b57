// Tests the choice of searched disparities against the oracle, and by properties that windows should have.
#include <gtest/gtest.h>

#include "compare.h"
#include "matching_scenes.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/sgm.h"

namespace hexrelief::matching::oracle {
namespace {

// The numbers of pixels whose runs are adjacent, and of those whose runs are apart.
struct Kinds {
    int together = 0, apart = 0;
    void count(const Runs& runs) {
        for (std::size_t i = 0; i < runs.far.values.size(); ++i)
            ++(runs.near.values[i] == runs.far.values[i] + runs.length ? together : apart);
    }
};

SearchWindows found_windows(const Scene& scene, const Disparities16& half, ThreadPool& pool) {
    return find_windows(scene.pair.left.width, scene.pair.left.height, config_of(scene.settings).range,
                        half.view(), pool);
}

// Calls body(scene, winners at half size, windows) for random winners.
template <typename Body>
void for_each_made_up(const Body& body) {
    ThreadPool pool(2);
    for (int number = 0; number < 10 * scene_count(); ++number) {
        const Scene scene = make_scene(4 * number + 3);
        const Grid half = any_half_winners(scene, number);
        body(scene, half, runs_of(found_windows(scene, map_of(half), pool), 16));
    }
}

TEST(WindowsOracle, AroundMadeUpDisparities) {
    Kinds kinds;
    for_each_made_up([&](const Scene& scene, const Grid& half, const Runs& runs) {
        const Runs expected = runs_around(half, runs.far.width, runs.far.height, scene.settings);
        EXPECT_EQ("", difference(expected.far, runs.far)) << scene.name;
        EXPECT_EQ("", difference(expected.near, runs.near)) << scene.name;
        kinds.count(runs);
    });
    EXPECT_GT(kinds.together, 50000);  // else the scenes test little
    EXPECT_GT(kinds.apart, 50000);
}

// Uses the matcher's own winners at half size.
TEST(WindowsOracle, AroundMatches) {
    ThreadPool pool(2);
    Kinds once, more;
    for (int number = 0; number < scene_count(); ++number) {
        const Scene scene = make_scene(number);
        Disparities16 half;
        if (is_wide(number))
            half = map_of(match_views(half_pair(scene.pair), half_settings(scene.settings)).left);
        const Runs expected = search_runs(scene.pair, scene.settings);
        const Runs found = runs_of(found_windows(scene, half, pool), expected.length);
        EXPECT_EQ("", difference(expected.far, found.far)) << scene.name;
        EXPECT_EQ("", difference(expected.near, found.near)) << scene.name;
        if (scene.settings.count > 64) (scene.settings.count > 128 ? more : once).count(found);
    }
    for (const Kinds& kinds : {once, more}) {  // with one level at half size, and with several
        EXPECT_GT(kinds.together, 1000);
        EXPECT_GT(kinds.apart, 1000);
    }
}

TEST(Windows, HoldAllOfASmallRange) {
    ThreadPool pool(2);
    for (int count = 1; count <= 64; ++count) {
        const Runs runs = runs_of(find_windows(70, 3, {-5, count}, {}, pool), 32);
        for (const int first : runs.far.values) ASSERT_EQ(first, 0);
        for (const int first : runs.near.values) ASSERT_EQ(first, 32);
    }
}

TEST(Windows, HoldThePixelsOwnDisparity) {
    int held = 0;
    for_each_made_up([&](const Scene& scene, const Grid& half, const Runs& runs) {
        const double min_px = scene.settings.min_px, half_min_px = half_settings(scene.settings).min_px;
        for (int y = 0; y < runs.far.height; ++y)
            for (int x = 0; x < runs.far.width; ++x) {
                const double own_px = 2 * (half_min_px + half.at(x / 2, y / 2) / 16.0) - min_px;
                if (own_px < 0 || own_px > scene.settings.count - 1) continue;
                const double in_far = own_px - runs.far.at(x, y), in_near = own_px - runs.near.at(x, y);
                ASSERT_TRUE((in_far >= 0 && in_far < 16) || (in_near >= 0 && in_near < 16))
                    << scene.name << ": " << x << ", " << y;
                ++held;
            }
    });
    EXPECT_GT(held, 100000);
}

TEST(Windows, HaveRunsInTheRangeThatDoNotOverlap) {
    for_each_made_up([&](const Scene& scene, const Grid&, const Runs& runs) {
        for (std::size_t i = 0; i < runs.far.values.size(); ++i) {
            const int far = runs.far.values[i], near = runs.near.values[i];
            ASSERT_TRUE(far % 4 == 0 && near % 4 == 0) << scene.name << ": " << far << ", " << near;
            ASSERT_TRUE(far >= 0 && near >= far + 16) << scene.name << ": " << far << ", " << near;
            ASSERT_LT(near + 16, scene.settings.count + 4) << scene.name;
        }
    });
}

// Paths continue between blocks whose windows differ.
TEST(Windows, GiveTheSameInBlocksOfAnySize) {
    ThreadPool one(1), two(2);
    for (int number = 3; number < 10 * scene_count(); number += 8) {
        const Scene scene = make_scene(number);
        const MatchingConfig config = config_of(scene.settings);
        const PairColors colors = split_colors(scene.pair, two);
        const SearchWindows windows = found_windows(scene, map_of(any_half_winners(scene, number)), two);
        const ViewDisparities whole = hexrelief::matching::match_views(
            colors.left, colors.right, config.range, windows.view(), config.penalties, two);
        const std::size_t row_bytes = std::size_t{3} * scene.pair.left.width * 2 * kShortRun;
        for (const std::size_t rows : {0, 5, 10}) {
            const ViewDisparities blocks =
                hexrelief::matching::match_views(colors.left, colors.right, config.range, windows.view(),
                                                 config.penalties, rows ? two : one, rows * row_bytes);
            EXPECT_EQ("", difference(grid_of(whole.left), grid_of(blocks.left)))
                << scene.name << ", " << rows;
            EXPECT_EQ("", difference(grid_of(whole.right), grid_of(blocks.right)))
                << scene.name << ", " << rows;
        }
    }
}

}  // namespace
}  // namespace hexrelief::matching::oracle
