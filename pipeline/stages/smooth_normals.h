// Smooths the normals of a matched pair's surface within the noise of its disparities.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// Replaces each normal by that of the mean of the disparity's gradients there and at the neighbours, several
// times, but for neighbours whose gradients differ by more than noise explains. The noise is the mesh's own:
// the median, over all edges, of what the gradients at both ends leave of the difference of the disparities,
// which is nothing on planes and quadrics. So creases stay, and on a smooth map everything does. Positions
// stay as they are. Needs image points, disparities and normals, in the space of `camera`.
void smooth_normals(SurfaceMesh& mesh, const Calibration& camera);

}  // namespace hexrelief::stages
