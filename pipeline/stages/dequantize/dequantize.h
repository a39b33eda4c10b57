// Replaces quantised disparities by the smoothest ones that round to them.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

struct Smoothness {
    // Weight of the given disparities against the bending of waves of one pixel. A wave twice as long bends
    // 16 times less. By default waves longer than some 30 px follow the given disparities.
    float pull = 0.002f;
    int levels = 5;  // sizes that are smoothed, each half of the one before
};

// Removes the quantisation steps of a map. A map of whole pixels, or of other steps of quantum_px > 0
// (find_quantum_px()), has a staircase on each slanted surface, which shows as rings when lit. Each disparity
// moves by less than half a step, to where the surface bends least. Nothing is smoothed across depth
// discontinuities (neighbours more than 1 px apart, unless down a column of a slope), and those of a map of
// whole pixels remain discontinuities. Unknown pixels stay unknown, and disparities of at most half a step
// are unchanged. The result is the same for any number of threads (>= 1).
DisparityMap dequantize(const DisparityMap& map, double quantum_px, int threads,
                        const Smoothness& smoothness = {});

// Moves the disparities of a matched map to where the right picture's levels fit best (Lucas & Kanade 1981)
// and the surface bends least. How much a pixel's levels count follows from how steep they are and how well
// the pictures agree, so a bare wall becomes the surface through what is beside it. How much surfaces bend
// follows from the map, and from how well the pictures still fit. pair: the pictures that the map was
// matched from, of at least 4 columns. Discontinuities (neighbours more than 1 px apart) stay, except
// those shorter than an 80th of the longer side, or than an 8th if they are blurred (ramps of some px), and
// those between pixels whose levels tell no disparity. Those shorter than a quarter that are soft (a tenth
// of what rises lies beside them) fall by 1 px per pixel from their nearer side on, over the farther one.
// Unknown pixels stay unknown, and no disparity leaves the map's range. The result is the same for any number
// of threads (>= 1).
DisparityMap refine_by_pictures(const DisparityMap& map, const StereoPair& pair, int threads);

}  // namespace hexrelief::stages
