// How one thread looks at rims: along ways, at their points, for their nearest cracks. Flags of pixels are
// taken eight at a time, so there are seven more behind the last one.
#pragma once

#include "mesher/steps/crossings.h"
#include "mesher/steps/jumps.h"
#include "mesher/steps/rim.h"
#include "pipeline/data/geometry.h"

namespace hexrelief {

// The first jump on a way.
step::Crossing walk(const step::PixelView& pixels, const step::Way& way);

// For the steps in steps/crossings.h.
struct PixelLook {
    step::PixelView pixels;
    step::TileView tiles;

    step::Crossing walk(const Vec2f& a, const Vec2f& b) const {
        return hexrelief::walk(pixels, step::way_between(a.x, a.y, b.x, b.y));
    }
    // The staircase of cracks around c becomes a line: weighted mean of their middles, with the mean of their
    // normals; the middle of c is moved onto it. Sums are taken row by row, right before down.
    step::RimPoint rim_point(const step::Crack& c) const;
    // The crack nearest to p within reach, the first of equals row by row, right before down; x < 0: none.
    step::Crack nearest_crack(const Vec2f& p, float reach_px) const;
};

}  // namespace hexrelief
