// Shares of the picture's pixels that are meshed, background, occluded or unknown.
#pragma once

#include <cstddef>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::job {

// Shares of the picture, 0..1. Known pixels are foreground or background, the others unknown or
// occluded; these four add up to 1. The mesh covers the foreground except slivers along its borders, and
// bridges small unknown regions.
struct PictureShares {
    double meshed = 0;      // by triangles
    double foreground = 0;  // known, and not removed as background
    double background = 0;
    double occluded = 0;  // unknown because the right camera cannot see it
    double unknown = 0;   // unknown for another reason

    double known() const { return foreground + background; }
};

// Measures the shares. `background_px` as in DensityMap; the surface's first `triangles` were made from
// `map`. blank: number of unknown pixels that no picture shows, which are of no share.
PictureShares share_picture(const DisparityMap& map, float background_px, const SurfaceMesh& surface,
                            std::size_t triangles, std::size_t blank = 0);

}  // namespace hexrelief::job
