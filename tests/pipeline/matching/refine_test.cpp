// Tests the refinement step by step against the oracle, on maps that no matcher would produce.
#include <gtest/gtest.h>

#include "compare.h"
#include "matching_scenes.h"
#include "pipeline/matching/refine/fill.h"
#include "pipeline/matching/refine/refine.h"
#include "pipeline/matching/refine/slopes.h"
#include "pipeline/matching/refine/votes.h"
#include "pipeline/matching/sgm/sgm.h"

namespace hexrelief::matching::oracle {
namespace {

// A picture, and maps of both views that need not be consistent.
struct Input {
    std::string name;
    Settings settings;
    StereoPair pair;
    Views views;
};

// Returns the matcher's own disparities, without refinement.
Views matched_views(const Scene& scene) {
    ThreadPool pool(1);
    const MatchingConfig config = config_of(scene.settings);
    const SearchWindows windows = windows_of(search_runs(scene.pair, scene.settings));
    const ViewDisparities views =
        hexrelief::matching::match_views(split_colors(scene.pair.left, Channels::grey, pool),
                                         split_colors(scene.pair.right, Channels::grey, pool), config.range,
                                         windows.view(), config.penalties, pool);
    return {grid_of(views.left), grid_of(views.right)};
}

Input make_input(int number) {
    const Scene scene = make_scene(number);
    Random random(1000 + number);
    const int width = scene.pair.left.width, height = scene.pair.left.height;
    const int most = 16 * scene.settings.count;
    Input input{scene.name, scene.settings, scene.pair, matched_views(scene)};
    if (random.one_in(2)) input.views.left = make_map(width, height, most, random);
    if (random.one_in(3)) input.views.right = make_map(width, height, most, random);
    return input;
}

Trusted grids_of(const TrustedMatches& matches) {
    return {grid_of(matches.left), grid_of(matches.right), grid_of(matches.nearest_seen)};
}
ViewDisparities maps_of(const Views& views) {
    return {map_of(views.left), map_of(views.right)};
}

// Sets values at unknown pixels to 0: the matcher's slopes are undefined there.
Grid where_known(Grid values, const Grid& map) {
    for (std::size_t i = 0; i < values.values.size(); ++i)
        if (map.values[i] == kUnknown) values.values[i] = 0;
    return values;
}

TEST(RefineOracle, MediansAndTrustedMatches) {
    ThreadPool pool(2);
    for (int number = 0; number < scene_count(); ++number) {
        const Input input = make_input(number);
        EXPECT_EQ("", difference(medians(input.views.left),
                                 grid_of(median_filtered(map_of(input.views.left), pool))))
            << input.name;
        const Trusted expected = trusted_matches(input.views, input.settings);
        const Trusted matches =
            grids_of(find_trusted_matches(maps_of(input.views), config_of(input.settings).consistency, pool));
        EXPECT_EQ("", difference(expected.left, matches.left)) << input.name;
        EXPECT_EQ("", difference(expected.right, matches.right)) << input.name;
        EXPECT_EQ("", difference(expected.nearest, matches.nearest)) << input.name;
    }
}

TEST(RefineOracle, Slopes) {
    ThreadPool pool(2);
    for (int number = 0; number < scene_count(); ++number) {
        const Input input = make_input(number);
        const Grid& map = input.views.left;
        for (const int stride : {1, 6}) {
            const Planes expected = slopes(map, stride);
            const hexrelief::matching::Slopes found = find_slopes(map_of(map), stride, pool);
            EXPECT_EQ("", difference(expected.x, where_known(grid_of(found.x), map))) << input.name;
            EXPECT_EQ("", difference(expected.y, where_known(grid_of(found.y), map))) << input.name;
        }
    }
}

TEST(RefineOracle, Filling) {
    ThreadPool pool(2);
    for (int number = 0; number < scene_count(); ++number) {
        const Input input = make_input(number);
        Trusted matches = trusted_matches(input.views, input.settings);
        if (number % 2) matches.left = input.views.left;
        if (number % 3 == 0) matches.right = input.views.right;
        const Planes planes = slopes(matches.left);
        const TrustedMatches trusted{map_of(matches.left), map_of(matches.right),
                                     raster_of<std::int32_t>(matches.nearest, kAnything)};
        const hexrelief::matching::Slopes slopes16{raster_of<std::int16_t>(planes.x, 0),
                                                   raster_of<std::int16_t>(planes.y, 0)};
        const int min_px = input.settings.min_px;
        const Grid filled =
            grid_of(fill_unknown({trusted, slopes16, split_colors(input.pair, pool), min_px}, pool));
        const Pictures pictures = read_pictures(input.pair);
        EXPECT_EQ("", difference(fill(matches, planes, pictures, min_px), filled)) << input.name;
    }
}

TEST(RefineOracle, WindowsAndVotes) {
    ThreadPool pool(2);
    for (int number = 0; number < scene_count(); ++number) {
        const Input input = make_input(number);
        Random random(2000 + number);
        const Trusted matches = trusted_matches(input.views, input.settings);
        const Grid map =
            fill(matches, slopes(matches.left), read_pictures(input.pair), input.settings.min_px);
        Grid windows = near_windows(map), weights(map.width, map.height, 0);
        EXPECT_EQ("", difference(windows, grid_of(near_discontinuities(map_of(map), pool)))) << input.name;
        for (int& window : windows.values) window = random.one_in(3) ? random.whole(3) : window;
        for (int& weight : weights.values) weight = random.whole(7);

        const Planes planes = slopes(map);
        const Voters voters{map, weights, matches.nearest, planes, input.settings.min_px};
        const ColorPlanes colors = split_colors(input.pair.left, Channels::as_they_are, pool);
        const hexrelief::matching::Slopes slopes16{raster_of<std::int16_t>(planes.x, 0),
                                                   raster_of<std::int16_t>(planes.y, 0)};
        const auto nearest = raster_of<std::int32_t>(matches.nearest, kAnything);
        const auto own_weights = raster_of<std::uint8_t>(weights, 0);
        const Disparities16 result = take_votes({map_of(map), slopes16, colors, blurred(colors, pool),
                                                 nearest, own_weights, input.settings.min_px},
                                                raster_of<VoteWindow>(windows, VoteWindow::none), pool);
        EXPECT_EQ("",
                  difference(votes(voters, read_picture(input.pair.left, false), windows), grid_of(result)))
            << input.name;
    }
}

TEST(RefineOracle, Smoothing) {
    ThreadPool pool(2);
    for (int number = 0; number < scene_count(); ++number) {
        const Input input = make_input(number);
        const ColorPlanes colors = split_colors(input.pair.left, Channels::as_they_are, pool);
        EXPECT_EQ("", difference(smooth(input.views.left, read_picture(input.pair.left, false)),
                                 grid_of(smoothed(map_of(input.views.left), colors, pool))))
            << input.name;
    }
}

TEST(RefineOracle, Sides) {
    ThreadPool pool(2);
    int changed = 0;
    for (int number = 0; number < scene_count(); ++number) {
        const Input input = make_input(number);
        const Grid nearest = trusted_matches(input.views, input.settings).nearest;
        const int min_px = input.settings.min_px;
        const Grid expected = sides(input.views.left, read_pictures(input.pair), nearest, min_px);
        const PairColors colors = split_colors(input.pair, pool);
        const auto seen = raster_of<std::int32_t>(nearest, kAnything);
        EXPECT_EQ("",
                  difference(expected,
                             grid_of(choose_sides(
                                 {map_of(input.views.left), colors.left, colors.right, seen, min_px}, pool))))
            << input.name;
        changed += difference(expected, input.views.left) != "";
    }
    EXPECT_GT(changed, 0);
}

TEST(RefineOracle, TheWhole) {
    for (int number = 0; number < scene_count(); ++number) {
        const Input input = make_input(number);
        const MatchedMap map = refine_views(input.pair, maps_of(input.views), config_of(input.settings), 2);
        const Result expected = refine(input.pair, input.views, nullptr, input.settings);
        EXPECT_EQ("", difference(expected.disparities, grid_of(map))) << input.name;
        EXPECT_EQ("", difference(expected.is_matched, matched_of(map))) << input.name;
    }
}

}  // namespace
}  // namespace hexrelief::matching::oracle
