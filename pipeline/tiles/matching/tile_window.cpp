#include "pipeline/tiles/matching/tile_window.h"

#include <algorithm>
#include <cstdlib>

#include "pipeline/stages/sgbm.h"

namespace hexrelief {
namespace {

int even_below(int px) {
    return std::max(0, px / 2 * 2);
}
int even_above(int px, int most) {
    return std::min((px + 1) / 2 * 2, most);
}

}  // namespace

MapRect window_of_tile(const MapRect& tile, const PairSize& whole, const DisparityConfig& ranged,
                       int collar_px) {
    const int least_px = ranged.min_disparity_px, count = ranged.num_disparities_px;
    const int reach_left = std::max(0, least_px + round_up_range(count)),
              reach_right = std::max(0, -least_px);
    int left = even_below(std::max(0, tile.x - collar_px - reach_left));
    int right = even_above(tile.x + tile.width + collar_px + reach_right, whole.width);
    // The matcher takes no range that is wider than the pictures.
    const int least_width = std::max({16, count, std::abs(least_px) + 1});
    right = std::max(right, even_above(left + least_width, whole.width));
    left = std::min(left, even_below(std::max(0, right - least_width)));
    const int top = even_below(std::max(0, tile.y - collar_px));
    const int bottom = even_above(tile.y + tile.height + collar_px, whole.height);
    return {left, top, right - left, bottom - top};
}

}  // namespace hexrelief
