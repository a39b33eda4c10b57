// The part of the rectified views that becomes the pair.
#pragma once

#include "pipeline/alignment/alignment.h"

namespace hexrelief::alignment {

// Returns what both views show at the given disparities, at most 1.6 times as large as the pictures. The
// right view is shifted so that the least disparity is little above 0. A width of 0 means that it is less
// than a fifth of the pictures. scale: as in bounds_of().
Canvas canvas_of(const Estimate& estimate, const DisparityBounds& bounds, double scale);

// Returns the bounds in px of the pair on the canvas.
DisparityBounds on_canvas(DisparityBounds bounds, const Canvas& canvas);

}  // namespace hexrelief::alignment
