// Steps 14 and 16 of the recipe in matching_oracle.h, as far as they concern the search, with steps 1 to 4.
#include <algorithm>
#include <array>
#include <cmath>

#include "matching_oracle.h"

namespace hexrelief::matching::oracle {
namespace {

int fours(int value) {
    return 4 * cut_down(value, 4);
}

Image half_of(const Image& image) {
    Image half{(image.width + 1) / 2, (image.height + 1) / 2, image.channels, {}};
    for (int y = 0; y < half.height; ++y)
        for (int x = 0; x < half.width; ++x)
            for (int c = 0; c < image.channels; ++c) {
                int sum = 0;
                for (const int row : {2 * y, std::min(2 * y + 1, image.height - 1)})
                    for (const int column : {2 * x, std::min(2 * x + 1, image.width - 1)})
                        sum += image.at(column, row)[c];
                half.pixels.push_back(static_cast<std::uint8_t>(rounded(sum, 4)));
            }
    return half;
}

// Returns the runs' first disparities, not yet limited by the ends of the range.
std::array<int, 2> free_runs(int own, int least, int largest) {
    if (largest - least <= 20) {
        const int far = fours((least + largest) / 2 - 14);
        return {far, far + 16};
    }
    const int other = own - least > largest - own ? least : largest;
    const int of_own = fours(own - 6), of_other = fours(other - 6);
    return {std::min(of_own, of_other), std::max(of_own, of_other)};
}

}  // namespace

int searched_end(const Settings& settings) {
    return settings.count <= 64 ? 64 : -fours(-settings.count);
}

StereoPair half_pair(const StereoPair& pair) {
    return {half_of(pair.left), half_of(pair.right)};
}

Settings half_settings(const Settings& settings) {
    Settings halved = settings;
    halved.min_px = static_cast<int>(std::floor(settings.min_px / 2.0));
    const int last_px = static_cast<int>(std::ceil((settings.min_px + settings.count - 1) / 2.0));
    halved.count = last_px - halved.min_px + 1;
    halved.least = settings.least / 2;
    return halved;
}

Runs whole_runs(int width, int height) {
    return {Grid(width, height, 0), Grid(width, height, 32), 32};
}

Runs runs_around(const Grid& half, int width, int height, const Settings& settings) {
    Runs runs{Grid(width, height, 0), Grid(width, height, 0), 16};
    const int beyond_px = 2 * half_settings(settings).min_px - settings.min_px;
    const int last = searched_end(settings) - 32;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::vector<int> around;
            for (int j = -2; j <= 2; ++j)
                for (int i = -2; i <= 2; ++i)
                    if (half.inside(x / 2 + i, y / 2 + j))
                        around.push_back(half.at(x / 2 + i, y / 2 + j) / 8 + beyond_px);
            const int own = half.at(x / 2, y / 2) / 8 + beyond_px;
            const auto [far, near] = free_runs(own, *std::min_element(around.begin(), around.end()),
                                               *std::max_element(around.begin(), around.end()));
            runs.far.at(x, y) = std::clamp(far, 0, last);
            runs.near.at(x, y) = std::clamp(near, runs.far.at(x, y) + 16, last + 16);
        }
    return runs;
}

Runs search_runs(const StereoPair& pair, const Settings& settings) {
    const int width = pair.left.width, height = pair.left.height;
    if (settings.count <= 64) return whole_runs(width, height);
    return runs_around(match_views(half_pair(pair), half_settings(settings)).left, width, height, settings);
}

Views match_views(const StereoPair& pair, const Settings& settings) {
    const auto [left, right] = read_pictures(pair);
    const Volume costs = match_costs(left, right, search_runs(pair, settings), settings);
    return winners(path_sums(left, costs, 0, settings), settings);
}

}  // namespace hexrelief::matching::oracle
