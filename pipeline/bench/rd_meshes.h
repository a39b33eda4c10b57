// The meshes that `hexrelief bench rd` compares. All are in the image: points in px, with a disparity each.
#pragma once

#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::bench::rd {

// Makes the mesh of a preset's configuration, on the CPU. Throws Error if the map leaves nothing to mesh.
SurfaceMesh preset_mesh(const DisparityMap& map, const config::Config& config, int threads);

// Makes a rectangular grid with a vertex about every spacing_px both ways, from the first pixel's centre to
// the last one's. Each vertex takes its pixel's disparity; triangles without a corner in the foreground (>=
// background_px) are left out.
SurfaceMesh uniform_mesh(const DisparityMap& map, float background_px, double spacing_px);

// Returns the vertices that these triangles use, in their order, and the triangles.
SurfaceMesh with_used_vertices(const SurfaceMesh& mesh, const std::vector<Triangle>& triangles);

// True if the program was built with meshoptimizer.
bool has_simplification();
// Returns meshoptimizer's simplification of a mesh to about `triangles`.
// Throws std::logic_error without meshoptimizer.
SurfaceMesh simplified_mesh(const SurfaceMesh& full, std::size_t triangles);
// Returns the mesh without triangles whose disparities differ by more than step_px.
SurfaceMesh without_steps(SurfaceMesh full, double step_px);

}  // namespace hexrelief::bench::rd
