// Stage: mesh over the image with a disparity at each vertex -> textured, metric surface in space.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_mesh.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

struct SpaceConfig {
    int min_component = 0;  // components of fewer triangles are dropped; 0 = keep all
};

// Z = focal * baseline / (d + doffs), X = (u - cx) Z / focal, Y = (v - cy) Z / focal, turned to glTF's axes
// (X, -Y, -Z). Dropped: triangles with a vertex that cannot be placed (d + doffs <= 0), those inverted or
// degenerate in the image, small components, isolated vertices. A vertex where two fans of triangles only
// touch is split, its copies side by side, so that the surface is manifold; else vertices keep the mesh's
// order. width, height: of the image, px. Throws Error(input) where nothing is left to mesh, the sizes do not
// fit, or the calibration's focal length or baseline is not positive.
SurfaceMesh build_surface(const DisparityMesh& cut_mesh, int width, int height,
                          const Calibration& calibration, const SpaceConfig& config);

}  // namespace hexrelief
