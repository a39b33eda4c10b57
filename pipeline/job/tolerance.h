// How exactly the positions of a surface are to be written.
#pragma once

#include "exporters/core/scene.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

// The tolerance of positions, px: config.tolerance_px, or, where tolerance_share is above 0 and that is less,
// this share of the surface's error away from discontinuities (SurfaceQuality::flat_rmse_px), at least
// kLeastTolerance_px.
inline constexpr double kLeastTolerance_px = 0.01;
double tolerance_for(const ExportConfig& config, const SurfaceMesh& surface, const DisparityMap& map,
                     float background_px, int threads);

}  // namespace hexrelief
