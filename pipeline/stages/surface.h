// Stage: from a mesh in the image with disparities to a textured, metric surface in space.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_mesh.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// Returns Z = focal * baseline / (d + doffs), X = (u - cx) Z / focal, Y = (v - cy) Z / focal, in glTF's axes:
// (X, -Y, -Z). Only for d + doffs > 0.
std::array<double, 3> position_in_space(double x_px, double y_px, double disparity,
                                        const Calibration& camera);

// Returns the mesh with its vertices at their positions in space. Dropped are triangles with a vertex that
// has no position (d + doffs <= 0), triangles that are inverted or degenerate in the image, connected
// components of fewer than min_component triangles, and isolated vertices. Non-manifold vertices are split,
// their copies adjacent to each other; vertices keep their order. width and height are the image's, in px.
// `sources`, if not null, gets for each vertex of the surface the vertex of cut_mesh that it comes from.
// Throws Error(input) if no triangle is left, the arrays' sizes differ, or the calibration's focal length or
// baseline is not positive.
SurfaceMesh build_surface(const DisparityMesh& cut_mesh, int width, int height,
                          const Calibration& calibration, int min_component,
                          std::vector<std::uint32_t>* sources = nullptr);

// Replaces each normal by that of the mean of the disparity's gradients there and at the neighbours, several
// times, but for neighbours whose gradients differ by more than noise explains, or by more than a quarter of
// quantum_px over the edge, if that is above 0: the step of a map that was smoothed within its steps. The
// noise is the mesh's own: the median, over all edges, of what the gradients at both ends leave of the
// difference of the disparities, which is nothing on planes and quadrics. So creases stay, and on a smooth
// map everything does. If quantum_px is 0, medians before and after replace what mismatches turn. Positions
// stay as they are. Needs image points, disparities and normals, in the space of `camera`.
void smooth_normals(SurfaceMesh& mesh, const Calibration& camera, double quantum_px = 0);

}  // namespace hexrelief::stages
