// Stage: 2D mesh with a disparity at each vertex -> textured, metric surface in space.
#pragma once

#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/hex_mesh.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

struct SurfaceConfig {
    // Triangles whose vertices differ by more are cut. 0 = chosen: more than both 1 px and 4 % of the spread
    // between the 2nd and 98th percentile of the map's foreground, and steeper than 0.5 px of disparity a
    // pixel. The slope keeps slanted floors, whose disparity changes a lot over a large triangle, but slowly;
    // a depth edge does it within a few pixels.
    double max_disparity_jump_px = 0;
    int min_component = 20;  // components of fewer triangles are dropped; 0 = keep all
};

// What the surface is made of. None of the pointers may be null; the map has the size of the image that the
// mesh covers.
struct SurfaceInput {
    const HexMesh2D* mesh = nullptr;
    const std::vector<float>* vertex_disparities =
        nullptr;  // one a lattice vertex, px; +inf = no foreground surface
    const DisparityMap* map = nullptr;
    float background_px =
        0;  // disparities below, and those not above 0, are background (DensityMap::background_px)
};

// Z = focal * baseline / (d + doffs), X = (u - cx) Z / focal, Y = (v - cy) Z / focal, turned to glTF's axes
// (X, -Y, -Z). Dropped: triangles with a vertex without disparity (or with d + doffs <= 0), those inverted or
// degenerate in the image, those whose inside is mostly background or unknown in the map, those across a
// depth jump, small components, isolated vertices. A vertex where two fans of triangles only touch is split,
// its copies side by side, so that the surface is manifold; else vertices keep the lattice's order. Throws
// Error(input) where nothing is left to mesh, the sizes do not fit, or the calibration's focal length or
// baseline is not positive.
SurfaceMesh build_surface(const SurfaceInput& input, const Calibration& calibration,
                          const SurfaceConfig& config);

}  // namespace hexrelief
