// How pixels and the cells and segments beside the frame tell each other of disparities.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::step {

// Of its columns or rows of pixels.
HEXRELIEF_HD int middle_of_cell(int cell, int cell_px) {
    return cell * cell_px + cell_px / 2;
}

// Whether a segment with so many cells may be a thing beyond the frame: one of 20 may be matched.
HEXRELIEF_HD bool may_be_beyond_frame(int unmatched, int matched) {
    constexpr int kFewMatches = 20;
    return unmatched > 0 && matched * kFewMatches <= unmatched;
}
// Of its unmatched cells' disparities in order, the number of the one that it has at least.
HEXRELIEF_HD int upper_quartile(int unmatched) {
    return (unmatched - 1) * 3 / 4;
}

// What a cell is told of its middle pixel.
HEXRELIEF_HD std::int16_t unmatched(std::int16_t match, std::int16_t filled) {
    return match == matching::kUnknown16 ? filled : matching::kUnknown16;
}

// What a pixel has then. least: of its cell.
HEXRELIEF_HD std::int16_t raised(std::int16_t match, std::int16_t filled, std::int16_t least) {
    return match == matching::kUnknown16 && filled < least ? least : filled;
}

}  // namespace hexrelief::step
