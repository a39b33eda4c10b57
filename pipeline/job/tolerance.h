// Tolerance of written positions, and the positions that compressed files hold.
#pragma once

#include <filesystem>
#include <vector>

#include "exporters/core/scene.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::job {

// Returns the tolerance of positions, px: config.tolerance_px if tolerance_share is 0, else min(tolerance_px,
// max(tolerance_share * SurfaceQuality::flat_rmse_px, kLeastTolerance_px)).
inline constexpr double kLeastTolerance_px = 0.01;
double tolerance_for(const exporters::ExportConfig& config, const SurfaceMesh& surface,
                     const DisparityMap& map, float background_px, int threads);

// True if a file at this path has quantised positions.
bool is_compressed(const std::filesystem::path& path, const exporters::ExportConfig& config);

// Returns the scene's mesh with the triangles, image points and disparities that a reader of the first
// compressed one of `outputs` gets; the mesh itself if no output is compressed. The scene has a camera, and
// all positions lie in front of it.
SurfaceMesh as_written(const exporters::Scene& scene, const exporters::ExportConfig& config,
                       const std::vector<std::filesystem::path>& outputs);

}  // namespace hexrelief::job
