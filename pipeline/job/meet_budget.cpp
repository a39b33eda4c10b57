#include "pipeline/job/meet_budget.h"

#include <algorithm>
#include <optional>

#include "exporters/compression/quantisation.h"
#include "exporters/exporter.h"
#include "pipeline/data/error.h"
#include "pipeline/job/outputs.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

// The surface as it is read back from compressed files: on the coarsest grid that keeps the tolerance.
SurfaceMesh as_written(const SurfaceMesh& surface, const Calibration& camera, double tolerance_px) {
    const auto grid = quantise_positions(surface, camera, tolerance_px, GridShape::cubic);
    SurfaceMesh seen;
    seen.triangles = surface.triangles;
    for (std::size_t i = 0; i < grid.cells.size(); ++i) {
        const double depth = -grid.value(i, 2);
        seen.image_points.push_back(
            {static_cast<float>(grid.value(i, 0) / depth * camera.focal_px + camera.cx),
             static_cast<float>(-grid.value(i, 1) / depth * camera.focal_px + camera.cy)});
        seen.disparities.push_back(
            static_cast<float>(camera.focal_px * camera.baseline_m / depth - camera.doffs_px));
    }
    return seen;
}

double largest_output(const LeftView& view, const SurfaceResult& result, const std::vector<fs::path>& outputs,
                      const RunContext& run) {
    const std::vector<DetailLevel> coarser = coarser_levels(view, result.config, run);
    const Scene scene = scene_of(view, result, coarser);
    std::uint64_t most = 0;
    for (const fs::path& path : outputs)
        most = std::max(most, export_size(scene, result.config.exporting, path));
    return static_cast<double>(most);
}

bool any_compressed(const std::vector<fs::path>& outputs, const ExportConfig& config) {
    return config.draco.position_bits == 0 &&
           std::any_of(outputs.begin(), outputs.end(), [&](const fs::path& path) {
               const MeshFormat format = export_format(path);
               return format == MeshFormat::drc ||
                      ((format == MeshFormat::glb || format == MeshFormat::gltf) &&
                       config.compression != Compression::none);
           });
}

}  // namespace

bool has_budget(const BudgetConfig& budget) {
    return budget.vertices > 0 || budget.max_bytes > 0 || budget.max_error_px > 0;
}

SurfaceResult meet_budget(const LeftView& view, const Config& config, const std::vector<fs::path>& outputs,
                          const RunContext& run) {
    std::optional<SurfaceResult> result;  // at solved_px; empty where nothing is left to mesh
    double solved_px = 0;
    BudgetJob search;
    search.start_px = config.mesh.spacing_px;
    search.most_px = std::min(256.0, std::min(view.disparity.width, view.disparity.height) / 4.0);
    search.tolerance_px = config.exporting.tolerance_px;
    search.compressed = any_compressed(outputs, config.exporting);
    search.solve = [&](double spacing_px, double tolerance_px) {
        Config tried = config;
        tried.mesh.spacing_px = spacing_px;
        tried.exporting.tolerance_px = tolerance_px;
        if (spacing_px == solved_px) {
            if (result) result->config = with_tolerance(tried, result->surface.mesh, view, run);
            return result.has_value();
        }
        solved_px = spacing_px;
        try {
            result = make_surface(view, tried, run);
        } catch (const Error& e) {
            if (e.kind() != ErrorKind::input) throw;
            result.reset();
            return false;
        }
        run.log.decide("spacing " + fixed(spacing_px, 2) + " px, tolerance " + fixed(tolerance_px, 3) +
                       " px: " + std::to_string(result->surface.mesh.positions.size()) + " vertices");
        return true;
    };
    search.vertices = [&] { return static_cast<double>(result->surface.mesh.positions.size()); };
    search.bytes = [&] { return largest_output(view, *result, outputs, run); };
    search.error_px = [&] {
        const SurfaceMesh& mesh = result->surface.mesh;
        const double tolerance_px = result->config.exporting.tolerance_px;
        return measure_surface_quality(
                   search.compressed ? as_written(mesh, view.calibration, tolerance_px) : mesh,
                   view.disparity, view.density.background_px, run.threads)
            .duo_rmse_near_px;
    };
    const BudgetResult found = fit_budget(config.budget, search);
    result->budget = found;
    result->budget.tolerance_px = result->config.exporting.tolerance_px;
    run.log.decide("budget " + found.kind + ": " + fixed(found.reached, 3) + " of " + fixed(found.limit, 3) +
                   " reached in " + std::to_string(found.solves) + " solves");
    return std::move(*result);
}

}  // namespace hexrelief
