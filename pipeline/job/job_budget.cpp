#include <algorithm>

#include "exporters/compression/quantisation.h"
#include "pipeline/job/budget.h"
#include "pipeline/job/job.h"
#include "pipeline/data/error.h"
#include "pipeline/stages/relief_quality.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;

// The surface as it is read back from compressed files: on the coarsest grid that keeps the tolerance.
SurfaceMesh as_written(const Job& job) {
    const Calibration& camera = job.report.calibration;
    const auto grid =
        quantise_positions(job.surface, camera, job.request.config.exporting.tolerance_px, GridShape::cubic);
    SurfaceMesh seen;
    seen.triangles = job.surface.triangles;
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

double largest_output(Job& job) {
    if (job.request.config.exporting.lod > 1) make_coarser_levels(job);
    const Scene scene = scene_of(job);
    std::uint64_t most = 0;
    for (const fs::path& path : job.request.outputs)
        most = std::max(most, export_size(scene, job.request.config.exporting, path));
    return static_cast<double>(most);
}

bool any_compressed(const RunRequest& request) {
    const ExportConfig& config = request.config.exporting;
    return config.draco.position_bits == 0 &&
           std::any_of(request.outputs.begin(), request.outputs.end(), [&](const fs::path& path) {
               const std::string format = export_format(path);
               return format == "drc" ||
                      ((format == "glb" || format == "gltf") && config.compression != Compression::none);
           });
}

}  // namespace

Scene scene_of(const Job& job) {
    Scene scene{&job.surface,
                job.texture.empty() ? nullptr : &job.texture,
                std::string("hexrelief ") + HEXRELIEF_VERSION,
                extras_json(job.report),
                &job.report.calibration,
                {}};
    for (const SurfaceMesh& mesh : job.coarser) scene.coarser.push_back(&mesh);
    return scene;
}

bool has_budget(const BudgetConfig& budget) {
    return budget.vertices > 0 || budget.max_bytes > 0 || budget.max_error_px > 0;
}

void meet_budget(Job& job) {
    Config& config = job.request.config;
    const bool compressed = any_compressed(job.request);
    BudgetJob search;
    search.start_px = config.mesh.spacing_px;
    search.most_px = std::min(256.0, std::min(job.map.width, job.map.height) / 4.0);
    search.tolerance_px = config.exporting.tolerance_px;
    search.compressed = compressed;
    search.solve = [&](double spacing_px, double tolerance_px) {
        const bool new_mesh = job.solved.mesh.positions.empty() || config.mesh.spacing_px != spacing_px;
        config.mesh.spacing_px = spacing_px;
        config.exporting.tolerance_px = tolerance_px;
        job.report.config = config;
        if (!new_mesh) {
            if (!job.surface.empty()) settle_tolerance(job);
            return !job.surface.empty();
        }
        try {
            make_surface(job);
        } catch (const Error& e) {
            if (e.kind() != ErrorKind::input) throw;
            job.surface = {};
            return false;
        }
        job.decide("spacing " + fixed(spacing_px, 2) + " px, tolerance " + fixed(tolerance_px, 3) +
                   " px: " + std::to_string(job.surface.positions.size()) + " vertices");
        return true;
    };
    search.vertices = [&] { return static_cast<double>(job.surface.positions.size()); };
    search.bytes = [&] { return largest_output(job); };
    search.error_px = [&] {
        return measure_relief(compressed ? as_written(job) : job.surface, job.map, job.density.background_px,
                              job.report.threads)
            .duo_rmse_near_px;
    };
    job.report.budget = fit_budget(config.budget, search);
    job.report.budget.tolerance_px = config.exporting.tolerance_px;
    const BudgetResult& result = job.report.budget;
    job.decide("budget " + result.kind + ": " + fixed(result.reached, 3) + " of " + fixed(result.limit, 3) +
               " reached in " + std::to_string(result.solves) + " solves");
}

}  // namespace hexrelief
