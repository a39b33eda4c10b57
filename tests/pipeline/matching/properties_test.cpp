// Tests properties that any matcher should have, independent of its recipe.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "compare.h"
#include "matching_scenes.h"
#include "pipeline/matching/sgm/paths.h"
#include "pipeline/matching/sgm/sgm.h"

namespace hexrelief::matching::oracle {
namespace {

// Returns both pictures of a surface with a smooth random texture; its disparity at column x of the left one
// is constant + gradient * x.
StereoPair slanted_pair(int width, int height, double constant, double gradient) {
    Random random(5);
    const Image knots = make_noise(width + 64, height, 1, random);
    const auto texture = [&](double x, int y) {
        const double at = std::clamp(x + 32, 0.0, width + 62.0);
        const int left = static_cast<int>(at);
        return knots.at(left, y)[0] + (at - left) * (knots.at(left + 1, y)[0] - knots.at(left, y)[0]);
    };
    StereoPair pair{{width, height, 1, {}}, {width, height, 1, {}}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double left_x = (x + constant) / (1 - gradient);
            pair.left.pixels.push_back(static_cast<std::uint8_t>(std::lround(texture(x, y))));
            pair.right.pixels.push_back(static_cast<std::uint8_t>(std::lround(texture(left_x, y))));
        }
    return pair;
}

// A square with the given disparity in front of a plane, both with random textures.
struct Box {
    int size, x0, x1, y0, y1, disparity, behind;
};
StereoPair box_pair(const Box& box) {
    Random random(7);
    StereoPair pair{make_noise(box.size, box.size, 3, random), make_noise(box.size, box.size, 3, random)};
    for (const bool front : {false, true})
        for (int y = 0; y < box.size; ++y)
            for (int x = 0; x < box.size; ++x) {
                const bool in_box = x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1;
                const int xr = x - (in_box ? box.disparity : box.behind);
                if (in_box == front && xr >= 0) std::copy_n(pair.left.at(x, y), 3, pair.right.at(xr, y));
            }
    return pair;
}

TEST(Matcher, GivesTheSameBytesOnAnyNumberOfThreads) {
    for (int number = 2; number < 30; number += 3) {
        const Scene scene = make_scene(number);
        const MatchedMap one = match_pair(scene.pair, config_of(scene.settings), 1);
        for (const int threads : {2, 3, 5}) {
            const MatchedMap other = match_pair(scene.pair, config_of(scene.settings), threads);
            EXPECT_EQ(one.disparities, other.disparities) << scene.name << ", " << threads;
            EXPECT_EQ(one.is_matched, other.is_matched) << scene.name << ", " << threads;
        }
    }
}

// Exact to 1/16 px, except near the border, which windows overlap.
TEST(Matcher, FindsAConstantShift) {
    const int width = 80, height = 40, border = 8;
    for (const int min_px : {-4, 0, 3}) {
        const int shift = min_px + 5;
        const MatchedMap map = match_pair(slanted_pair(width, height, shift, 0), config_of({min_px, 16}), 2);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const bool inside = std::min({x - shift, width - 1 - x, y, height - 1 - y}) >= border;
                const int found = map.disparities[static_cast<std::size_t>(y) * width + x];
                EXPECT_LE(std::abs(found - 16 * 5), inside ? 1 : 16) << min_px << ": " << x << ", " << y;
            }
    }
}

// On a floor that comes nearer from row to row stands an object of one colour, left of the part that the
// right picture shows. It is as near as the floor at its foot, not as far as the surfaces behind its top.
TEST(Matcher, TakesWhatStandsBeyondTheFrameForOneThing) {
    Random random(9);
    const int width = 120, height = 96, thing_columns = 12, top = 20, foot = 84;
    StereoPair pair{make_noise(width, height, 3, random), make_noise(width, height, 3, random)};
    const auto floor_px = [](int y) { return 2 + y / 4; };
    for (int y = 0; y < height; ++y) {
        for (int x = floor_px(y); x < width; ++x)
            std::copy_n(pair.left.at(x, y), 3, pair.right.at(x - floor_px(y), y));
        for (int x = 0; x < thing_columns && y >= top && y < foot; ++x)
            std::copy_n(std::array<std::uint8_t, 3>{200, 30, 40}.data(), 3, pair.left.at(x, y));
    }
    const MatchedMap map = match_pair(pair, config_of({0, 48}), 2);
    for (int y = top + 4; y < top + 20; ++y)
        for (int x = 0; x < thing_columns - 4; ++x)
            EXPECT_GT(map.disparities[static_cast<std::size_t>(y) * width + x], 16 * 14) << x << ", " << y;
}

TEST(Matcher, FindsASlantedPlane) {
    for (const double gradient : {0.05, -0.08, 0.12}) {
        const double constant = gradient < 0 ? 14 : 3;
        const MatchedMap map = match_pair(slanted_pair(100, 60, constant, gradient), config_of({0, 20}), 2);
        double error = 0;
        for (int y = 0; y < 60; ++y)
            for (int x = 0; x < 100; ++x)
                error += std::fabs(map.disparities[static_cast<std::size_t>(y) * 100 + x] / 16.0 -
                                   (constant + gradient * x));
        EXPECT_LT(error / 6000, 1.0 / 8) << gradient;
    }
}

TEST(Matcher, GivesHiddenPixelsTheBackgroundsDisparity) {
    const Box box{80, 35, 60, 20, 60, 14, 4};
    const MatchedMap map = match_pair(box_pair(box), config_of({0, 20}), 2);
    for (int y = box.y0 + 4; y < box.y1 - 4; ++y)
        for (int x = box.x0 - (box.disparity - box.behind); x < box.x0; ++x) {
            const std::size_t pixel = static_cast<std::size_t>(y) * box.size + x;
            EXPECT_LE(std::abs(map.disparities[pixel] - 16 * box.behind), 4) << x << ", " << y;
            EXPECT_EQ(map.is_matched[pixel], 0) << x << ", " << y;
        }
}

// More of the range lies between the two surfaces than a pixel's window can hold.
TEST(Matcher, FindsSurfacesFarApart) {
    const Box box{320, 210, 290, 60, 140, 168, 16};
    const MatchedMap map = match_pair(box_pair(box), config_of({0, 200}), 2);
    int matched = 0, wrong = 0;
    for (int y = 0; y < box.size; ++y)
        for (int x = 0; x < box.size; ++x) {
            const bool in_box = x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1;
            const std::size_t pixel = static_cast<std::size_t>(y) * box.size + x;
            matched += map.is_matched[pixel];
            wrong += map.is_matched[pixel] &&
                     std::abs(map.disparities[pixel] - 16 * (in_box ? box.disparity : box.behind)) > 4;
        }
    const int beyond_frame = box.size * box.behind;
    const int hidden = (box.x1 - box.x0) * (box.y1 - box.y0);
    EXPECT_GT(matched, (box.size * box.size - beyond_frame - hidden) * 99 / 100);
    EXPECT_LE(wrong, 4);  // the corners are smoothed away
}

bool sees_match(const Grid& is_matched, int x, int y) {
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            for (int k = 0; (dx || dy) && is_matched.inside(x + k * dx, y + k * dy); ++k)
                if (is_matched.at(x + k * dx, y + k * dy)) return true;
    return false;
}

TEST(Matcher, LeavesPixelsUnknownOnlyWhereNothingMatched) {
    int unknown = 0;
    for (int number = 0; number < scene_count(); ++number) {
        const Scene scene = make_scene(number);
        const MatchedMap map = match_pair(scene.pair, config_of(scene.settings), 2);
        const Grid disparities = grid_of(map), is_matched = matched_of(map);
        const std::vector<int> half_size = match_at_half_size(scene.pair, scene.settings).left.values;
        const bool none = std::count(map.is_matched.begin(), map.is_matched.end(), 1) == 0 &&
                          std::count(half_size.begin(), half_size.end(), kUnknown) ==
                              static_cast<std::ptrdiff_t>(half_size.size());
        for (int y = 0; y < map.height; ++y)
            for (int x = 0; x < map.width; ++x) {
                const bool known = disparities.at(x, y) != kUnknown;
                EXPECT_FALSE(none && known) << scene.name;
                EXPECT_TRUE(known || !sees_match(is_matched, x, y)) << scene.name << ": " << x << ", " << y;
                unknown += !known;
            }
    }
    EXPECT_GT(unknown, 0);
}

TEST(Matcher, TakesBandsOfRowsThatFitIntoMemory) {
    EXPECT_EQ(band_rows(400, 300), 300);
    for (const int width : {2000, 5000, 20000, 100000}) {
        const int rows = band_rows(width, 4000);
        const std::size_t bytes = std::size_t{3} * width * rows * kWholeRange;
        EXPECT_TRUE(bytes <= kLargestVolume_bytes || rows == 2 * kBandMargin + 16) << width;
        EXPECT_GT(rows, 2 * kBandMargin);
        EXPECT_LE(rows, 4000);
    }
    EXPECT_EQ(band_rows(100000, 100), 100);
}

TEST(Matcher, BandsKeepEachRowOnce) {
    for (const int height : {1, 100, 145, 4000}) {
        int next = 0;
        for (const Band& band : bands_of(100000, height)) {
            EXPECT_EQ(band.kept.first, next);
            EXPECT_GT(band.kept.count(), 0);
            EXPECT_LE(band.rows.count(), band_rows(100000, height));
            EXPECT_EQ(band.rows.first, std::max(0, band.kept.first - kBandMargin));
            EXPECT_EQ(band.rows.end, std::min(height, band.kept.end + kBandMargin));
            next = band.kept.end;
        }
        EXPECT_EQ(next, height);
    }
}

// Uses bands like those of match_views() for a large picture, with margins. Away from the bands' borders, and
// in fact at them as well, the winners are those of the whole picture.
TEST(Matcher, FindsTheSameInBandsOfRows) {
    ThreadPool pool(2);
    const int width = 40, height = 230, kept = 40;
    const StereoPair pair = slanted_pair(width, height, 3, 0.1);
    const ColorPlanes left = split_colors(pair.left, Channels::as_they_are, pool);
    const ColorPlanes right = split_colors(pair.right, Channels::as_they_are, pool);
    const DisparityRange range{0, 12};
    const SearchWindows windows(width, height, kWholeWindow);
    const ViewDisparities whole =
        hexrelief::matching::match_views(left, right, range, windows.view(), {}, pool);
    ViewDisparities bands{Disparities16(width, height, kUnknown16), Disparities16(width, height, kUnknown16)};
    for (int y = 0; y < height; y += kept) {
        const int end = std::min(height, y + kept);
        const int first = std::max(0, y - kBandMargin), last = std::min(height, end + kBandMargin);
        const MatchingInput input{left, right, range, windows.view(), {}};
        MatchingVolume volume(width, first, last - first, run_length(range));
        aggregate_alone(input, volume, pool);
        find_winners(input, volume, y, end, bands, pool);
    }
    EXPECT_EQ("", difference(grid_of(whole.left), grid_of(bands.left)));
    EXPECT_EQ("", difference(grid_of(whole.right), grid_of(bands.right)));
}

// The vertical paths continue from block to block.
TEST(Matcher, FindsTheSameInBlocksOfAnySize) {
    ThreadPool pool(2);
    const int width = 40, height = 230;
    const StereoPair pair = slanted_pair(width, height, 3, 0.1);
    const ColorPlanes left = split_colors(pair.left, Channels::as_they_are, pool);
    const ColorPlanes right = split_colors(pair.right, Channels::as_they_are, pool);
    const DisparityRange range{-2, 19};
    const SearchWindows windows(width, height, kWholeWindow);
    const ViewDisparities whole =
        hexrelief::matching::match_views(left, right, range, windows.view(), {}, pool);
    const std::size_t row_bytes = std::size_t{3} * width * kWholeRange;
    for (const std::size_t rows : {0, 33, 115, 229}) {
        const ViewDisparities blocks =
            hexrelief::matching::match_views(left, right, range, windows.view(), {}, pool, rows * row_bytes);
        EXPECT_EQ("", difference(grid_of(whole.left), grid_of(blocks.left))) << rows;
        EXPECT_EQ("", difference(grid_of(whole.right), grid_of(blocks.right))) << rows;
    }
}

}  // namespace
}  // namespace hexrelief::matching::oracle
