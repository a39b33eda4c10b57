// What became of the picture's pixels.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::job {

// Shares of the picture, 0..1. Known pixels are foreground or background, the others are unknown or occluded,
// and these four add up to 1. The mesh covers the foreground but for slivers along its borders, and bridges
// small unknown places.
struct PictureShares {
    double meshed = 0;      // by triangles
    double foreground = 0;  // known, and not removed as background
    double background = 0;
    double occluded = 0;  // unknown, where the right camera cannot see: behind what is next on the right, or
                          // left of its picture
    double unknown = 0;   // otherwise

    double known() const { return foreground + background; }
};

// `background_px` as in DensityMap; `surface` was made from `map`.
PictureShares share_picture(const DisparityMap& map, float background_px, const SurfaceMesh& surface);

}  // namespace hexrelief::job
