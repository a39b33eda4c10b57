// Stage: mesh over the image with a disparity at each vertex -> textured, metric surface in space.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_mesh.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// Z = focal * baseline / (d + doffs), X = (u - cx) Z / focal, Y = (v - cy) Z / focal, turned to glTF's axes:
// (X, -Y, -Z). Only for d + doffs > 0.
std::array<double, 3> position_in_space(double x_px, double y_px, double disparity,
                                        const Calibration& camera);

// The mesh's vertices at their positions in space. Dropped: triangles with a vertex that cannot be placed (d
// + doffs <= 0), those inverted or degenerate in the image, components of fewer than min_component triangles,
// isolated vertices. Non-manifold vertices are split, their copies next to each other; the order of the
// vertices stays. width, height: of the image, px. Throws Error(input) where nothing is left to mesh, the
// sizes do not fit, or the calibration's focal length or baseline is not positive.
// sources, where it is not null, is told the vertex of cut_mesh that each of the surface's comes from.
SurfaceMesh build_surface(const DisparityMesh& cut_mesh, int width, int height,
                          const Calibration& calibration, int min_component,
                          std::vector<std::uint32_t>* sources = nullptr);

}  // namespace hexrelief::stages
