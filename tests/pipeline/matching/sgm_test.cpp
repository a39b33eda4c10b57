// Tests semi-global matching step by step against the oracle.
#include <gtest/gtest.h>

#include "compare.h"
#include "matching_scenes.h"
#include "pipeline/matching/sgm/costs.h"
#include "pipeline/matching/sgm/paths.h"
#include "pipeline/matching/sgm/sgm.h"

namespace hexrelief::matching::oracle {
namespace {

template <typename T>
std::vector<int> numbers(const LargeArray<T>& array, std::size_t count) {
    return {array.data(), array.data() + count};
}

// Every other wide scene is searched around disparities that are not its own and that jump more often.
Runs any_runs(const Scene& scene, int number) {
    if (!is_wide(number) || number % 8 == 3) return search_runs(scene.pair, scene.settings);
    return runs_around(any_half_winners(scene, number), scene.pair.left.width, scene.pair.left.height,
                       scene.settings);
}

TEST(SgmOracle, Colors) {
    ThreadPool pool(2);
    for (int number = 0; number < scene_count(); ++number) {
        const Scene scene = make_scene(number);
        const PairColors pictures = split_colors(scene.pair, pool);
        const Pictures oracle = read_pictures(scene.pair);
        ASSERT_EQ(oracle.left.channels.size(), static_cast<std::size_t>(pictures.left.channels));
        EXPECT_EQ("", difference(oracle.left.grey, grid_of(pictures.left.grey))) << scene.name;
        for (std::size_t c = 0; c < oracle.left.channels.size(); ++c)
            EXPECT_EQ("", difference(oracle.left.channels[c], grid_of(pictures.left.planes[c])))
                << scene.name;
    }
}

void expect_same(const Scene& scene, const Runs& runs, ThreadPool& pool) {
    const Settings& settings = scene.settings;
    const PairColors pictures = split_colors(scene.pair, pool);
    const Pictures oracle = read_pictures(scene.pair);
    const MatchingConfig config = config_of(settings);
    const SearchWindows windows = windows_of(runs);
    MatchingVolume volume(scene.pair.left.width, 0, scene.pair.left.height, runs.length);
    aggregate_alone({pictures.left, pictures.right, config.range, windows.view(), config.penalties}, volume,
                    pool);
    const Volume costs = match_costs(oracle.left, oracle.right, runs, settings);
    const Volume sums = path_sums(oracle.left, costs, 0, settings);
    ASSERT_EQ(entries_of(costs, runs), numbers(volume.costs, volume.entries())) << scene.name;
    ASSERT_EQ(entries_of(sums, runs), numbers(volume.sums, volume.entries())) << scene.name;

    const ViewDisparities views =
        match_views(pictures.left, pictures.right, config.range, windows.view(), config.penalties, pool);
    const Views expected = winners(sums, settings);
    EXPECT_EQ("", difference(expected.left, grid_of(views.left))) << scene.name;
    EXPECT_EQ("", difference(expected.right, grid_of(views.right))) << scene.name;
}

TEST(SgmOracle, CostsSumsAndWinners) {
    ThreadPool pool(2);
    for (int number = 0; number < scene_count(); ++number) {
        const Scene scene = make_scene(number);
        expect_same(scene, any_runs(scene, number), pool);
    }
}

// Windows jump from pixel to pixel, more often than they do at half size, with the largest penalties.
TEST(SgmOracle, WindowsThatJumpAnywhere) {
    ThreadPool pool(2);
    for (int number = 3; number < scene_count(); number += 8) {
        Scene scene = make_scene(number);
        scene.settings.p1 = 15999;
        scene.settings.p2 = 16000;
        Random random(4000 + number);
        Runs runs = search_runs(scene.pair, scene.settings);
        const int last = searched_end(scene.settings) / 4 - 8;
        for (std::size_t i = 0; i < runs.far.values.size(); ++i) {
            const int far = random.between(0, last);
            runs.far.values[i] = 4 * far;
            runs.near.values[i] = 16 + 4 * random.between(far, last);
        }
        expect_same(scene, runs, pool);
    }
}

// Downward and upward paths begin at a band's first and last row.
TEST(SgmOracle, PathsOfABandOfRows) {
    ThreadPool pool(2);
    for (int number = 2; number < scene_count(); number += 5) {
        const Scene scene = make_scene(number);
        const PairColors pictures = split_colors(scene.pair, pool);
        const Pictures oracle = read_pictures(scene.pair);
        const MatchingConfig config = config_of(scene.settings);
        const int first = scene.pair.left.height / 6, rows = scene.pair.left.height / 2;
        if (rows == 0) continue;
        const Runs runs = any_runs(scene, number);
        const SearchWindows windows = windows_of(runs);
        MatchingVolume volume(scene.pair.left.width, first, rows, runs.length);
        aggregate_alone({pictures.left, pictures.right, config.range, windows.view(), config.penalties},
                        volume, pool);
        const Volume costs = match_costs(oracle.left, oracle.right, runs, scene.settings);
        Volume band{costs.width, rows, costs.count, {}};
        const std::size_t row = static_cast<std::size_t>(costs.width) * costs.count;
        band.values.assign(costs.values.begin() + first * row, costs.values.begin() + (first + rows) * row);
        ASSERT_EQ(entries_of(band, runs, first), numbers(volume.costs, volume.entries())) << scene.name;
        ASSERT_EQ(entries_of(path_sums(oracle.left, band, first, scene.settings), runs, first),
                  numbers(volume.sums, volume.entries()))
            << scene.name;
    }
}

}  // namespace
}  // namespace hexrelief::matching::oracle
