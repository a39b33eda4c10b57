#include "pipeline/job/surfaces.h"

#include <algorithm>

#include "pipeline/checks/thresholds.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"
#include "pipeline/job/other_views.h"
#include "pipeline/stages/join_crumbs.h"
#include "pipeline/stages/silhouettes.h"
#include "pipeline/stages/surface.h"
#include "pipeline/stages/surface_quality.h"

namespace hexrelief::job {
namespace {

constexpr double kLeastTolerance_px = 0.01;

std::string memory_text(const DeviceFigures& device) {
    return fixed(static_cast<double>(device.bytes) / (1 << 20), 1) + " MiB of its memory";
}

HexMesh2D solve_lattice(const LeftView& view, const MeshConfig& config, Backend& backend, const RunLog& log) {
    backend.expect_map(view.meshed);
    HexMesh2D lattice =
        backend.solve_mesh(view.density, config, [&log](double share) { log.progress(share); });
    const DeviceFigures device = backend.figures();
    if (device.bytes > 0)
        log.decide("device: training " + fixed(device.training_s * 1e3, 3) + " ms, balancing " +
                   fixed(device.balance_s * 1e3, 3) + " ms on its own clock, " + memory_text(device));
    log.decide("lattice: " + std::to_string(lattice.columns) + " x " + std::to_string(lattice.rows) + ", " +
               std::to_string(lattice.iterations) + " iterations on " + backend.name());
    return lattice;
}

SurfaceMesh coarser_level(int level, const LeftView& view, const config::Config& config,
                          const SurfaceResult& finest, Backend& backend, const RunLog& log) {
    const int levels = config.exporting.lod;
    const auto progress = [&](double share) { log.progress((level - 1 + share) / (levels - 1)); };
    try {
        backend.expect_map(view.meshed);
        const HexMesh2D lattice = backend.solve_mesh(view.density, config.mesh, progress);
        SurfaceMesh mesh =
            surface_of(cut_lattice(lattice, view, config.surface, backend, log), view, config.surface);
        add_other_views(mesh, finest, view, config, backend, log);
        return mesh;
    } catch (const Error& error) {
        throw Error(error.kind(), "level of detail " + std::to_string(level) + " at a spacing of " +
                                      fixed(config.mesh.spacing_px, 1) + " px: " + error.what() +
                                      "; or lower export.lod");
    }
}

}  // namespace

DensityMap density_of(const DisparityMap& disparity, const stages::DensityConfig& config, int threads,
                      RunLog& log) {
    DensityMap density = stages::compute_density(disparity, config, threads);
    const auto count_of = [&](const auto& counted) {
        return std::count_if(disparity.values.begin(), disparity.values.end(),
                             [&](float d) { return DisparityMap::known(d) && counted(d); });
    };
    const auto kept = count_of([&](float d) { return d > 0 && d >= density.background_px; });
    if (kept == 0)
        throw Error(ErrorKind::input,
                    "nothing is left to mesh: no known disparity above the background threshold of " +
                        fixed(density.background_px, 2) +
                        " px; check the input or lower density.background.fraction");
    log.decide((density.background_px > 0 ? "background: below " + fixed(density.background_px, 2) + " px; "
                                          : std::string("background: nothing is removed; ")) +
               fixed(100.0 * static_cast<double>(kept) / static_cast<double>(density.values.size()), 1) +
               " % of the image is foreground");
    const auto gone = count_of([&](float d) { return d < density.background_px; });
    if (config.background_method == stages::BackgroundMethod::automatic && gone > kept)
        log.warn("more goes as background than stays, " +
                 checks::percent(static_cast<double>(gone) / static_cast<double>(gone + kept)) +
                 " of what is known: all that lies farther than " + fixed(1 / config.background_fraction, 1) +
                 " times the nearest; set density.background.method=none to keep it");
    return density;
}

DisparityMesh cut_lattice(const HexMesh2D& lattice, const LeftView& view, const SurfaceConfig& config,
                          Backend& backend, const RunLog& log) {
    const float background_px = view.density.background_px;
    DisparityMesh cut = backend.cut_disparity_mesh({&lattice, &view.meshed, background_px}, config);
    const DeviceFigures device = backend.figures();
    if (device.surface_s > 0)
        log.decide("device: cut and fit " + fixed(device.surface_s * 1e3, 3) + " ms on its own clock, " +
                   memory_text(device));
    stages::adjust_silhouettes(cut, view.disparity, background_px, config.silhouette_rounds);
    const double cell_px = static_cast<double>(view.meshed.values.size()) / lattice.positions.size();
    // Half of what is smaller than a cell is wrong in matched maps.
    stages::join_crumbs(cut, cell_px, view.is_matched ? cell_px : 0);
    // Planes are fitted beyond their pixels.
    for (float& d : cut.disparities) d = std::max(d, view.least_px);
    return cut;
}

SurfaceMesh surface_of(const DisparityMesh& cut_mesh, const LeftView& view, const SurfaceConfig& config) {
    const int width = view.disparity.width, height = view.disparity.height;
    SurfaceMesh mesh = stages::build_surface(cut_mesh, width, height, view.calibration, config.min_component);
    if (view.is_uneven()) stages::smooth_normals(mesh, view.calibration, view.quantum_px);
    return mesh;
}

SurfaceResult make_surface(const LeftView& view, const config::Config& config, Backend& backend,
                           RunLog& log) {
    const int threads = backend.threads();
    SurfaceResult result;
    result.lattice = log.stage("mesh", [&] { return solve_lattice(view, config.mesh, backend, log); });
    const HexMesh2D& lattice = result.lattice;
    auto quality =
        start_work(threads, [&] { return quality::measure_quality(lattice, view.density, threads); });
    log.stage("surface", [&] {
        const DisparityMesh cut = cut_lattice(lattice, view, config.surface, backend, log);
        result.device = backend.figures();
        result.mesh = surface_of(cut, view, config.surface);
        result.left_bounds = bounds_of(result.mesh.positions);
        if (config.surface.views == SurfaceViews::both && view.is_whole)
            add_other_views(result, view, config, backend, log);
        result.bounds = bounds_of(result.mesh.positions);
        log.decide("depth: " + fixed(result.nearest(), 3) + " to " + fixed(result.farthest(), 3) +
                   (view.calibration.metric ? " m" : " (relative)"));
    });
    result.quality = log.stage("quality", [&] { return quality.get(); });
    result.config = config;
    if (config.exporting.tolerance_share > 0)
        result.config =
            log.stage("tolerance", [&] { return with_tolerance(config, result.mesh, view, threads, log); });
    return result;
}

config::Config with_tolerance(const config::Config& config, const SurfaceMesh& surface, const LeftView& view,
                              int threads, const RunLog& log) {
    config::Config effective = config;
    exporters::ExportConfig& exporting = effective.exporting;
    if (!(exporting.tolerance_share > 0)) return effective;
    const double error_px =
        stages::measure_surface_quality(surface, view.disparity, view.density.background_px, threads)
            .flat_rmse_px;
    // rounded, because machines may differ in the last bits of the measured error
    const double wanted_px = std::max(
        kLeastTolerance_px, 1e-3 * static_cast<long long>(1e3 * exporting.tolerance_share * error_px));
    exporting.tolerance_px = std::min(exporting.tolerance_px, wanted_px);
    log.decide("tolerance: " + fixed(exporting.tolerance_px, 3) + " px");
    return effective;
}

void warn_of_inversions(const quality::MeshQuality& quality, RunLog& log) {
    if (quality.inverted_triangles > 0)
        log.warn(std::to_string(quality.inverted_triangles) +
                 " triangles of the 2D mesh are inverted; more iterations (mesh.t_max) may help");
}

std::vector<SurfaceMesh> coarser_levels(const LeftView& view, const SurfaceResult& finest, Backend& backend,
                                        const RunLog& log) {
    std::vector<SurfaceMesh> levels;
    config::Config coarser = finest.config;
    for (int level = 1; level < coarser.exporting.lod; ++level) {
        coarser.mesh.spacing_px *= 2;
        levels.push_back(coarser_level(level, view, coarser, finest, backend, log));
        const SurfaceMesh& mesh = levels.back();
        log.decide("level of detail " + std::to_string(level) + ": " + fixed(coarser.mesh.spacing_px, 1) +
                   " px, " + std::to_string(mesh.positions.size()) + " vertices, " +
                   std::to_string(mesh.triangles.size()) + " triangles");
    }
    return levels;
}

}  // namespace hexrelief::job
