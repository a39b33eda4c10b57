#include "pipeline/stages/densify/sparsity.h"

#include <algorithm>

namespace hexrelief::stages {
namespace {

constexpr double kJoined = 0.5;
constexpr double kLeastKnown = 0.001;  // fewer measurements show no surface

double share(long long part, long long whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

}  // namespace

bool Sparsity::is_sparse() const {
    return known_share >= kLeastKnown && std::min(joined_along_rows, joined_along_columns) < kJoined;
}

Sparsity measure_sparsity(const DisparityMap& map) {
    long long known = 0, with_right = 0, with_below = 0, right = 0, below = 0;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            if (!DisparityMap::known(map.at(x, y))) continue;
            ++known;
            if (x + 1 < map.width) {
                ++with_right;
                right += DisparityMap::known(map.at(x + 1, y));
            }
            if (y + 1 < map.height) {
                ++with_below;
                below += DisparityMap::known(map.at(x, y + 1));
            }
        }
    return {share(known, static_cast<long long>(map.values.size())), share(right, with_right),
            share(below, with_below)};
}

}  // namespace hexrelief::stages
