// Tests the spiral search against brute force.
#include "mesher/som/best_matching_unit_step.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hexrelief::step {
namespace {

struct Neurons {
    std::vector<float> x, y;
    std::vector<std::uint32_t> start, ids;

    void sort_into(const CellGrid& grid) {
        std::vector<std::vector<std::uint32_t>> cells(static_cast<std::size_t>(grid.columns) * grid.rows);
        for (std::uint32_t i = 0; i < x.size(); ++i) cells[cell_of(grid, x[i], y[i])].push_back(i);
        start = {0};
        ids.clear();
        for (const auto& cell : cells) {
            ids.insert(ids.end(), cell.rbegin(), cell.rend());  // any order must do
            start.push_back(static_cast<std::uint32_t>(ids.size()));
        }
    }
    CellLists lists() const { return {start.data(), start.data() + 1, ids.data()}; }

    std::uint32_t nearest(float px, float py) const {
        std::uint32_t best = 0;
        const auto distance = [&](std::uint32_t i) {
            return (x[i] - px) * (x[i] - px) + (y[i] - py) * (y[i] - py);
        };
        for (std::uint32_t i = 1; i < x.size(); ++i)
            if (distance(i) < distance(best)) best = i;
        return best;
    }
};

// whole: at whole pixels, so that distances often tie.
Neurons random_neurons(int count, int width, int height, bool whole, std::uint32_t seed) {
    std::mt19937 random(seed);
    Neurons neurons;
    for (int i = 0; i < count; ++i) {
        const double u = static_cast<double>(random()) / 4294967296.0,
                     v = static_cast<double>(random()) / 4294967296.0;
        // crowded towards one corner, so that many cells are empty
        const auto x = static_cast<float>(u * u * width), y = static_cast<float>(v * v * height);
        neurons.x.push_back(whole ? std::floor(x) : x);
        neurons.y.push_back(whole ? std::floor(y) : y);
    }
    return neurons;
}

TEST(SpiralSearch, UnlimitedOnFreshListsIsTheNearestOfAll) {
    const int width = 93, height = 71;
    for (const int co : {1, 4, 10, 17, 100})
        for (const int count : {1, 2, 30, 400})
            for (const bool whole : {false, true}) {
                const CellGrid grid = make_cell_grid(width, height, co);
                Neurons neurons =
                    random_neurons(count, width, height, whole, static_cast<std::uint32_t>(co + count));
                neurons.sort_into(grid);
                for (int py = 0; py < height; py += 7)
                    for (int px = 0; px < width; px += 5) {
                        const Candidate found = spiral_search(grid, neurons.lists(), neurons.x.data(),
                                                              neurons.y.data(), {2 * px + 1, 2 * py + 1}, 0);
                        ASSERT_EQ(found.neuron, neurons.nearest(static_cast<float>(px) + 0.5f,
                                                                static_cast<float>(py) + 0.5f))
                            << "pixel " << px << ", " << py << " co " << co << " neurons " << count;
                    }
            }
}

TEST(SpiralSearch, NeuronsOnTheImageBorderAreFound) {
    const CellGrid grid = make_cell_grid(40, 30, 10);
    Neurons neurons;
    neurons.x = {40, 0, 40, 0};
    neurons.y = {30, 30, 0, 0};
    neurons.sort_into(grid);
    const auto find = [&](int px, int py) {
        return spiral_search(grid, neurons.lists(), neurons.x.data(), neurons.y.data(),
                             {2 * px + 1, 2 * py + 1}, 0)
            .neuron;
    };
    EXPECT_EQ(find(39, 29), 0u);
    EXPECT_EQ(find(0, 29), 1u);
    EXPECT_EQ(find(39, 0), 2u);
    EXPECT_EQ(find(0, 0), 3u);
}

TEST(SpiralSearch, RangeEndsTheSearch) {
    const CellGrid grid = make_cell_grid(100, 100, 10);
    Neurons neurons;
    neurons.x = {95};
    neurons.y = {5};
    neurons.sort_into(grid);
    const auto find = [&](int ssr) {
        return spiral_search(grid, neurons.lists(), neurons.x.data(), neurons.y.data(),
                             {2 * 45 + 1, 2 * 5 + 1}, ssr)
            .neuron;
    };
    EXPECT_EQ(find(4), kNoNeuron);
    EXPECT_EQ(find(5), 0u);
    EXPECT_EQ(find(0), 0u);
}

}  // namespace
}  // namespace hexrelief::step
