// Segments of the left picture beside its frame. Points left of the right picture have no match. If a whole
// object lies there, none of its pixels match, and filling assigns them to the surfaces behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::matching {

// A grid of square cells, some 150 along the longer side. Pixels beyond the last whole cell belong to none. A
// narrow picture has no cells.
struct CellGrid {
    int cell_px, columns, rows;

    std::size_t size() const { return static_cast<std::size_t>(columns) * rows; }
};
CellGrid cell_grid(int width, int height);

// The cells beside the frame, sorted by segment: those of segment i are cells[firsts[i]] to cells[firsts[i
// + 1] - 1].
struct FrameSegments {
    CellGrid grid;            // the left picture's
    int columns;              // number of the grid's columns beside the frame
    std::vector<int> cells;   // indices in the grid, row by row
    std::vector<int> firsts;  // one more than there are segments

    int count() const { return static_cast<int>(firsts.size()) - 1; }
};

// Finds segments of one colour (Felzenszwalb and Huttenlocher 2004) in the columns that a disparity of
// most_px can lead beyond the frame.
FrameSegments find_frame_segments(const Image& left, int most_px);

// Returns for each cell of the grid the least disparity of its unmatched pixels; kUnknown16 if there is no
// limit. `filled` holds for each cell, row by row, the disparity that filling gave to its middle pixel
// (step::middle_of_cell), in 1/16 px above min_px; kUnknown16 if that pixel was matched.
//
// A segment with hardly any match is an object, or a part of one. It stands where the surfaces around it are
// near, so its disparity is at least the upper quartile of its cells' filled disparities.
std::vector<std::int16_t> least_disparities(const FrameSegments& segments,
                                            const std::vector<std::int16_t>& filled);

}  // namespace hexrelief::matching
