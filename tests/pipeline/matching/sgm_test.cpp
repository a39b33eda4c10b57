// Semi-global matching, step by step, against the oracle.
#include <gtest/gtest.h>

#include "compare.h"
#include "pipeline/matching/sgm/costs.h"
#include "pipeline/matching/sgm/paths.h"
#include "pipeline/matching/sgm/sgm.h"
#include "pipeline/matching/sgm/winners.h"
#include "scenes.h"

namespace hexrelief::oracle {
namespace {

template <typename T>
std::vector<int> numbers(const LargeArray<T>& array, std::size_t count) {
    return {array.data(), array.data() + count};
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

TEST(SgmOracle, CostsSumsAndWinners) {
    ThreadPool pool(2);
    for (int number = 0; number < scene_count(); ++number) {
        const Scene scene = make_scene(number);
        const Settings& settings = scene.settings;
        const PairColors pictures = split_colors(scene.pair, pool);
        const Pictures oracle = read_pictures(scene.pair);
        const MatchingConfig config = config_of(settings);
        const int width = scene.pair.left.width, height = scene.pair.left.height;
        MatchingVolume volume(width, 0, height, settings.count);
        aggregate_alone({pictures.left, pictures.right, config.range, config.penalties}, volume, pool);
        const Volume costs = match_costs(oracle.left, oracle.right, settings);
        const Volume sums = path_sums(oracle.left, costs, 0, settings);
        ASSERT_EQ(costs.values, numbers(volume.costs, volume.entries())) << scene.name;
        ASSERT_EQ(sums.values, numbers(volume.sums, volume.entries())) << scene.name;

        const ViewDisparities views =
            match_views(pictures.left, pictures.right, config.range, config.penalties, pool);
        const Views expected = winners(sums, settings.min_px);
        EXPECT_EQ("", difference(expected.left, grid_of(views.left))) << scene.name;
        EXPECT_EQ("", difference(expected.right, grid_of(views.right))) << scene.name;
    }
}

// Paths down and up begin at a band's first and last row.
TEST(SgmOracle, PathsOfABandOfRows) {
    ThreadPool pool(2);
    for (int number = 2; number < scene_count(); number += 10) {
        const Scene scene = make_scene(number);
        const PairColors pictures = split_colors(scene.pair, pool);
        const Pictures oracle = read_pictures(scene.pair);
        const MatchingConfig config = config_of(scene.settings);
        const int first = 7, rows = 19;
        MatchingVolume volume(scene.pair.left.width, first, rows, config.range.count);
        aggregate_alone({pictures.left, pictures.right, config.range, config.penalties}, volume, pool);
        const Volume costs = match_costs(oracle.left, oracle.right, scene.settings);
        Volume band{costs.width, rows, costs.count, {}};
        const std::size_t row = static_cast<std::size_t>(costs.width) * costs.count;
        band.values.assign(costs.values.begin() + first * row, costs.values.begin() + (first + rows) * row);
        ASSERT_EQ(band.values, numbers(volume.costs, volume.entries())) << scene.name;
        ASSERT_EQ(path_sums(oracle.left, band, first, scene.settings).values,
                  numbers(volume.sums, volume.entries()))
            << scene.name;
    }
}

}  // namespace
}  // namespace hexrelief::oracle
