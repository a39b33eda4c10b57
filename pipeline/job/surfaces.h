// The surface of a run, from its disparities on: density, lattice, cut mesh, points in space; and the search
// for the surface that keeps a budget.
#pragma once

#include <filesystem>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/job/relief.h"

namespace hexrelief::job {

// Computes the density of a map. Warns if most of it is background. Throws Error(input) if all of it is.
DensityMap density_of(const DisparityMap& disparity, const stages::DensityConfig& config, int threads,
                      RunLog& log);

// Cuts the lattice along the view's silhouettes, and makes the cut mesh a surface in the view's space.
DisparityMesh cut_lattice(const HexMesh2D& lattice, const LeftView& view, const SurfaceConfig& config,
                          Backend& backend, const RunLog& log);
SurfaceMesh surface_of(const DisparityMesh& cut_mesh, const LeftView& view, const SurfaceConfig& config);

// Runs the stages mesh and surface, quality in parallel with surface, then tolerance if configured.
SurfaceResult make_surface(const LeftView& view, const config::Config& config, Backend& backend, RunLog& log);

// Returns the configuration, its tolerance lowered by the surface's own error if export.tolerance_share is
// above 0: min(tolerance_px, max(tolerance_share * SurfaceQuality::flat_rmse_px, 0.01)).
config::Config with_tolerance(const config::Config& config, const SurfaceMesh& surface, const LeftView& view,
                              int threads, const RunLog& log);

void warn_of_inversions(const quality::MeshQuality& quality, RunLog& log);

// Returns export.lod - 1 coarser levels of the surface, each at twice the spacing of the one before. Throws
// as make_surface().
std::vector<SurfaceMesh> coarser_levels(const LeftView& view, const SurfaceResult& finest, Backend& backend,
                                        const RunLog& log);

// Repeats make_surface() with other spacings and tolerances until the surface keeps the configured limit
// (budget.h). The result's configuration and budget hold what was found. A limit on bytes applies to the
// largest of `outputs`. Throws Error(usage) if the limit is out of reach.
SurfaceResult meet_budget(const LeftView& view, const config::Config& config,
                          const std::vector<std::filesystem::path>& outputs, Backend& backend, RunLog& log);

}  // namespace hexrelief::job
