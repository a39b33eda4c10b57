// Segments of the left picture beside its frame. What lies left of the right picture has no match; where a
// whole thing lies there, nothing of it has, and filling takes it for the surfaces behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief {

// Square cells, some 150 along the longer side; pixels beyond the last whole one are in none. A narrow
// picture has no cells.
struct CellGrid {
    int cell_px, columns, rows;

    std::size_t size() const { return static_cast<std::size_t>(columns) * rows; }
};
CellGrid cell_grid(int width, int height);

// Neighbouring cells beside the frame, which may be found before anything is matched.
struct FrameEdge {
    int a, b;  // cells of `frame`, row by row
    int step;  // of their colours
};
struct FrameEdges {
    CellGrid whole, frame;          // of the left picture, and as many of its columns as may count
    std::vector<FrameEdge> sorted;  // from the least step to the largest
};
// most_px: the largest disparity that is searched.
FrameEdges find_frame_edges(const Image& left, int most_px);

// filled: of each cell of the whole grid, row by row, what filling gave to the pixel in its middle
// (step::middle_of_cell), in 1/16 px above min_px; kUnknown16 where that was matched. Returns the disparity
// that a cell's unmatched pixels have at least, kUnknown16 where they may have any.
// A segment of one colour (Felzenszwalb and Huttenlocher 2004) that has hardly a match is a thing, or a part
// of one. It stands where the surfaces around it are near, so it has at least the upper quartile of what
// filling gave to its cells.
std::vector<std::int16_t> least_disparities(const FrameEdges& edges, int min_px,
                                            const std::vector<std::int16_t>& filled);

}  // namespace hexrelief
