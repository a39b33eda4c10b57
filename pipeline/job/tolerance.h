// How finely a surface is worth being written.
#pragma once

#include "exporters/core/scene.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

// The tolerance of positions, px: tolerance_px, or where tolerance_share is above 0 and the surface is so
// exact that this is less, that share of its error away from discontinuities (measure_relief). At least
// kLeastTolerance_px then.
inline constexpr double kLeastTolerance_px = 0.01;
double tolerance_for(const ExportConfig& config, const SurfaceMesh& surface, const DisparityMap& map,
                     float background_px, int threads);

}  // namespace hexrelief
