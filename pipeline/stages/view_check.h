// What follows StereoSGBM: the check against the other view, and the removal of speckles.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Disparities of one view as the matcher gives them: row-major, 1/16 px, kUnmatched where matching failed.
struct RawDisparities {
    int width = 0;
    int height = 0;
    std::vector<std::int16_t> values;
};
inline constexpr std::int16_t kUnmatched = INT16_MIN;
inline constexpr int kRawScale = 16;

// Unmatches every pixel of `left` whose match lies outside the right image, is unmatched there, or has a
// disparity that differs by more than `limit_px`; of the two right pixels that a sub-pixel match falls
// between, one has to agree.
void check_left_right(RawDisparities& left, const RawDisparities& right, double limit_px);

// Unmatches patches of at most window_px neighbouring pixels whose disparities differ by at most range_px
// from neighbour to neighbour; 0 = none.
void remove_speckles(RawDisparities& map, int window_px, int range_px);

}  // namespace hexrelief::stages
