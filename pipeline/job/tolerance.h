// How exactly the positions of a surface are to be written, and what compressed files hold of them.
#pragma once

#include <filesystem>
#include <vector>

#include "exporters/core/scene.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::job {

// The tolerance of positions, px: config.tolerance_px, or, where tolerance_share is above 0 and that is less,
// this share of the surface's error away from discontinuities (SurfaceQuality::flat_rmse_px), at least
// kLeastTolerance_px.
inline constexpr double kLeastTolerance_px = 0.01;
double tolerance_for(const exporters::ExportConfig& config, const SurfaceMesh& surface,
                     const DisparityMap& map, float background_px, int threads);

// True if a file at this path has quantised positions.
bool is_compressed(const std::filesystem::path& path, const exporters::ExportConfig& config);

// Triangles, image points and disparities of the scene's mesh as they are read back from the first of
// `outputs` that is compressed; the mesh itself if none is. The scene has a camera, before which all
// positions lie.
SurfaceMesh as_written(const exporters::Scene& scene, const exporters::ExportConfig& config,
                       const std::vector<std::filesystem::path>& outputs);

}  // namespace hexrelief::job
