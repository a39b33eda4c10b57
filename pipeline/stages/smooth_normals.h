// Smooths normals within what the disparities of a surface support.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// Replaces each normal by that of the mean of the disparity's gradients there and at the neighbours, several
// times, but for neighbours whose gradients differ by more than noise explains, or by more than a quarter of
// quantum_px over the edge, if that is above 0: the step of a map that was smoothed within its steps. The
// noise is the mesh's own: the median, over all edges, of what the gradients at both ends leave of the
// difference of the disparities, which is nothing on planes and quadrics. So creases stay, and on a smooth
// map everything does. Positions stay as they are. Needs image points, disparities and normals, in the space
// of `camera`.
void smooth_normals(SurfaceMesh& mesh, const Calibration& camera, double quantum_px = 0);

}  // namespace hexrelief::stages
