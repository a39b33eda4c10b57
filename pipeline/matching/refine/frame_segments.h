// Segments of the left picture beside its frame. What lies left of the right picture has no match; where a
// whole thing lies there, nothing of it has, and filling takes it for the surfaces behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::matching {

// Square cells, some 150 along the longer side; pixels beyond the last whole one are in none. A narrow
// picture has no cells.
struct CellGrid {
    int cell_px, columns, rows;

    std::size_t size() const { return static_cast<std::size_t>(columns) * rows; }
};
CellGrid cell_grid(int width, int height);

// The cells that lie beside the frame, segment after segment: those of number i from firsts[i] to
// firsts[i + 1] - 1.
struct FrameSegments {
    CellGrid grid;            // of the left picture
    int columns;              // of the grid, that lie there
    std::vector<int> cells;   // of the grid, row by row
    std::vector<int> firsts;  // one more than there are segments

    int count() const { return static_cast<int>(firsts.size()) - 1; }
};

// Segments of one colour (Felzenszwalb and Huttenlocher 2004), of the columns that a disparity of most_px may
// lead beyond the frame.
FrameSegments find_frame_segments(const Image& left, int most_px);

// filled: of each cell of the grid, row by row, what filling gave to the pixel in its middle
// (step::middle_of_cell), in 1/16 px above min_px; kUnknown16 where that was matched. Returns the disparity
// that a cell's unmatched pixels have at least, kUnknown16 where they may have any.
// A segment that has hardly a match is a thing, or a part of one. It stands where the surfaces around it are
// near, so it has at least the upper quartile of what filling gave to its cells.
std::vector<std::int16_t> least_disparities(const FrameSegments& segments,
                                            const std::vector<std::int16_t>& filled);

}  // namespace hexrelief::matching
