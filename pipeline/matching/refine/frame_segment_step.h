// Exchanges disparities between pixels and the cells and segments beside the frame.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::step {

// Returns the middle of a cell, in columns or rows of pixels.
HEXRELIEF_HD int middle_of_cell(int cell, int cell_px) {
    return cell * cell_px + cell_px / 2;
}

// True if a segment with so many cells may be an object beyond the frame: at most one in 20 may be matched.
HEXRELIEF_HD bool may_be_beyond_frame(int unmatched, int matched) {
    constexpr int kFewMatches = 20;
    return unmatched > 0 && matched * kFewMatches <= unmatched;
}
// Returns the index of the upper quartile among a segment's sorted disparities of unmatched cells.
HEXRELIEF_HD int upper_quartile(int unmatched) {
    return (unmatched - 1) * 3 / 4;
}

// Returns the value that a cell takes from its middle pixel: the filled disparity if that
// pixel was not matched.
HEXRELIEF_HD std::int16_t unmatched(std::int16_t match, std::int16_t filled) {
    return match == matching::kUnknown16 ? filled : matching::kUnknown16;
}

// Returns the pixel's new disparity: an unmatched pixel has at least `least`, the value of its cell.
HEXRELIEF_HD std::int16_t raised(std::int16_t match, std::int16_t filled, std::int16_t least) {
    return match == matching::kUnknown16 && filled < least ? least : filled;
}

}  // namespace hexrelief::step
