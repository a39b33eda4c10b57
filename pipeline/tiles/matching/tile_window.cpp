#include "pipeline/tiles/matching/tile_window.h"

#include <algorithm>
#include <cstdlib>

#include "pipeline/stages/sgbm.h"

namespace hexrelief::tiles {
namespace {

// Windows are aligned to this. Pictures with the largest range are halved five times, so all windows share
// the pixels of the halved pictures.
constexpr int kAligned_px = 32;
int aligned_below(int px) {
    return std::max(0, px / kAligned_px * kAligned_px);
}
int aligned_above(int px, int most) {
    return std::min((px + kAligned_px - 1) / kAligned_px * kAligned_px, most);
}

}  // namespace

mesh_tiles::MapRect window_of_tile(const mesh_tiles::MapRect& tile, const PairSize& whole,
                                   const stages::DisparityConfig& ranged, int collar_px) {
    const int least_px = ranged.min_disparity_px, count = ranged.num_disparities_px;
    const int reach_left = std::max(0, least_px + stages::round_up_range(count)),
              reach_right = std::max(0, -least_px);
    int left = aligned_below(std::max(0, tile.x - collar_px - reach_left));
    int right = aligned_above(tile.x + tile.width + collar_px + reach_right, whole.width);
    // The matcher does not accept a range wider than the pictures.
    const int least_width = std::max({16, count, std::abs(least_px) + 1});
    right = std::max(right, aligned_above(left + least_width, whole.width));
    left = std::min(left, aligned_below(std::max(0, right - least_width)));
    const int top = aligned_below(std::max(0, tile.y - collar_px));
    const int bottom = aligned_above(tile.y + tile.height + collar_px, whole.height);
    return {left, top, right - left, bottom - top};
}

}  // namespace hexrelief::tiles
