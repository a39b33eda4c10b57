// How pixels and the cells beside the frame tell each other of disparities.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/raster.h"

namespace hexrelief::step {

// Of its columns or rows of pixels.
HEXRELIEF_HD int middle_of_cell(int cell, int cell_px) {
    return cell * cell_px + cell_px / 2;
}

// What a cell is told of its middle pixel.
HEXRELIEF_HD std::int16_t unmatched(std::int16_t match, std::int16_t filled) {
    return match == kUnknown16 ? filled : kUnknown16;
}

// What a pixel has then. least: of its cell.
HEXRELIEF_HD std::int16_t raised(std::int16_t match, std::int16_t filled, std::int16_t least) {
    return match == kUnknown16 && filled < least ? least : filled;
}

}  // namespace hexrelief::step
