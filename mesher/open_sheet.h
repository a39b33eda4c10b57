// Lays the lattice over the scene: along silhouettes, opened at depth jumps, at fitted disparities.
#pragma once

#include "mesher/sheet_config.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/hex_mesh.h"
#include "pipeline/data/image.h"
#include "pipeline/data/sheet_mesh.h"

namespace hexrelief {

struct SheetInput {
    const HexMesh2D* mesh = nullptr;    // not null
    const DisparityMap* map = nullptr;  // not null, of the image that the mesh covers
    float background_px = 0;            // disparities below, and those not above 0, are background
    const Image* color = nullptr;       // the left image, of the map's size; null = none
};

// 1. Depth jumps are found between neighbouring pixels (pixel_surfaces.h), borders of the foreground among
// them.
// 2. Vertices move onto the rims that these form (align.h); where they cannot, triangles are split.
// 3. Each triangle gets the surface of most of its pixels; those on none are dropped; vertices between
// surfaces are
//    doubled.
// 4. Disparities are fitted to each triangle's own pixels, by least squares (steps/vertex_fit.h).
// 5. Small triangles that even so span a step are dropped: needles in space.
// The same bytes for any number of threads. Throws Error(input) where the sizes do not fit or the map is
// empty.
SheetMesh open_sheet(const SheetInput& input, const SheetConfig& config, int threads);

}  // namespace hexrelief
