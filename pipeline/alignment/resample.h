// The aligned pair.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/alignment/alignment.h"
#include "pipeline/data/calibration.h"

namespace hexrelief::alignment {

// Returns what both views show at the given disparities, at most 1.6 times as large as the pictures. The
// right view is shifted so that the least disparity is little above 0. A width of 0 means that it is less
// than a fifth of the pictures. scale: as in bounds_of().
Canvas canvas_of(const Estimate& estimate, const DisparityBounds& bounds, double scale);

// Returns the bounds in px of the pair on the canvas.
DisparityBounds on_canvas(DisparityBounds bounds, const Canvas& canvas);

struct AlignedPair {
    StereoPair pair;
    // For each pixel of the left view, row-major, top row first: 1 = inside the picture as taken, and the
    // right view shows what lies there at one of the pair's disparities.
    std::vector<std::uint8_t> seen;
    std::vector<std::uint8_t> right_seen;  // of the right view: 1 = inside the picture as taken
};

// Resamples both pictures, by cubic interpolation at positions in 1/32 px. Pixels outside the left picture
// repeat its border; pixels outside the right one are noise that matches nothing, for a plain border would
// match others. alignment: one with the verdict `aligned`, of this pair. The same bytes for any number of
// threads.
// Without `has_right` the right picture stays empty; all else is the same.
AlignedPair aligned_pair(const StereoPair& pair, const Alignment& alignment, int threads,
                         bool has_right = true);

// Returns the direction that is up in the left picture as given, in its aligned view: a unit vector, x to the
// right and y up. (0, 1) if the picture was not turned.
std::array<double, 2> up_of(const Alignment& alignment);

// Returns the camera of the aligned pair; its baseline is 0, not known.
Calibration camera_of(const Alignment& alignment);

}  // namespace hexrelief::alignment
