#include "pipeline/job/surfaces.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "exporters/exporter.h"
#include "exporters/images/texture.h"
#include "pipeline/checks/thresholds.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/data/start_work.h"
#include "pipeline/job/other_views.h"
#include "pipeline/job/outputs.h"
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
    log.decide("lattice: " + size_text(lattice.columns, lattice.rows, " x ") + ", " +
               std::to_string(lattice.iterations) + " iterations on " + backend.name());
    return lattice;
}

// Tells the left view's vertices that were filled, if this is asked for and the map knows.
void tell_filled(SurfaceMesh& mesh, const DisparityMap& map, exporters::ProvenanceKind kind) {
    if (kind != exporters::ProvenanceKind::matches || map.origins.empty()) return;
    mesh.provenance.resize(mesh.positions.size(), Provenance::left);
    for (std::size_t i = 0; i < mesh.left_vertices(); ++i) {
        const Vec2f& point = mesh.image_points[i];
        const int x = std::clamp(static_cast<int>(std::lround(point.x)), 0, map.width - 1);
        const int y = std::clamp(static_cast<int>(std::lround(point.y)), 0, map.height - 1);
        if (map.origins[static_cast<std::size_t>(y) * map.width + x] == PixelOrigin::filled)
            mesh.provenance[i] = Provenance::filled;
    }
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
        add_other_views(mesh, finest, view, config, backend.threads(), log);
        tell_filled(mesh, view.disparity, config.exporting.provenance);
        return mesh;
    } catch (const Error& error) {
        throw Error(error.kind(), "level of detail " + std::to_string(level) + " at a spacing of " +
                                      fixed(config.mesh.spacing_px, 1) + " px: " + error.what() +
                                      "; or lower export.lod");
    }
}

namespace fs = std::filesystem;

double largest_output(const LeftView& view, const SurfaceResult& result,
                      const std::vector<SurfaceMesh>& coarser, const std::vector<fs::path>& outputs,
                      int threads, const RunLog& log) {
    exporters::Scene scene = scene_of(view, result, coarser);
    exporters::PageContent page;
    if (has_page(outputs)) {
        const stages::SurfaceQuality quality = quality_as_written(view, result, outputs, threads);
        tell_quality(quality, log);
        page = page_content(view, result, quality, threads);
        scene.page = &page;
    }
    std::uint64_t most = 0;
    for (const fs::path& path : outputs)
        most = std::max(most, exporters::export_size(scene, result.config.exporting, path));
    return static_cast<double>(most);
}

// True if the tolerance changes the bytes of some output.
bool any_compressed(const std::vector<fs::path>& outputs, const exporters::ExportConfig& config) {
    return config.draco.position_bits == 0 && std::ranges::any_of(outputs, [&](const fs::path& path) {
               return is_compressed(path, config) && !exporters::export_format(path).tolerance_px;
           });
}

// Returns the texture settings that the search may change: those that the configuration does not give. None
// if no output has a texture.
std::optional<TextureLimits> texture_limits(const LeftView& view, const config::Config& config,
                                            const std::vector<fs::path>& outputs) {
    const exporters::ExportConfig& exporting = config.exporting;
    const bool is_written = std::ranges::any_of(outputs, [](const fs::path& path) {
        return exporters::export_format(path).colours == exporters::ColourStorage::texture;
    });
    if (view.texture.empty() || !is_written || !exporting.texcoords ||
        exporting.texture == exporters::TextureFormat::none)
        return std::nullopt;
    TextureLimits limits{{exporting.texture_max_px, exporting.texture_quality},
                         std::max(view.texture.width, view.texture.height),
                         !config.given.contains("export.texture_max_px"),
                         !config.given.contains("export.texture_quality") &&
                             exporting.texture != exporters::TextureFormat::png};
    if (exporting.texture_max_px > 0)
        limits.longest_px = std::min(limits.longest_px, exporting.texture_max_px);
    return limits;
}

exporters::ExportConfig with_texture(exporters::ExportConfig config, const TextureChoice& texture) {
    config.texture_max_px = texture.max_px;
    config.texture_quality = texture.quality;
    return config;
}

std::string text_of(const TextureChoice& texture) {
    return "texture of quality " + std::to_string(texture.quality) + ", " +
           (texture.max_px > 0 ? "at most " + std::to_string(texture.max_px) + " px" : "as large as it is");
}

double texture_bytes(const LeftView& view, const SurfaceResult& result, const TextureChoice& texture) {
    const exporters::ExportConfig config = with_texture(result.config.exporting, texture);
    const exporters::Scene scene = scene_of(view, result, {});
    return static_cast<double>(
        exporters::encode_texture(scene, exporters::textured_mesh(scene, config), config).bytes.size());
}

SurfaceResult search_spacing(const LeftView& view, const config::Config& given,
                             const std::vector<fs::path>& outputs, Backend& backend, RunLog& log) {
    const int threads = backend.threads();
    config::Config config = given;        // with the texture in use
    std::optional<SurfaceResult> result;  // at solved_px; empty = nothing is left to mesh
    std::vector<SurfaceMesh> coarser;     // coarser levels of that mesh
    double solved_px = 0;
    BudgetJob search;
    const double side_px = std::min(view.disparity.width, view.disparity.height);
    const double coarsest_level = std::ldexp(1, config.exporting.lod - 1);  // in spacings; three fit
    search.most_px = std::max(search.least_px, std::min({256.0, side_px / 4, side_px / 3 / coarsest_level}));
    search.start_px = std::min(config.mesh.spacing_px, search.most_px);
    search.tolerance_px = config.exporting.tolerance_px;
    search.compressed = any_compressed(outputs, config.exporting);
    search.solve = [&](double spacing_px, double tolerance_px) {
        config::Config tried = config;
        tried.mesh.spacing_px = spacing_px;
        tried.exporting.tolerance_px = tolerance_px;
        if (spacing_px == solved_px) {
            if (result) result->config = with_tolerance(tried, result->mesh, view, threads, log);
            return result.has_value();
        }
        solved_px = spacing_px;
        try {
            result = make_surface(view, tried, backend, log);
            coarser = coarser_levels(view, *result, backend, log);
        } catch (const Error& e) {
            if (e.kind() != ErrorKind::input) throw;
            result.reset();
            return false;
        }
        log.decide("spacing " + fixed(spacing_px, 2) + " px, tolerance " + fixed(tolerance_px, 3) +
                   " px: " + std::to_string(result->mesh.positions.size()) + " vertices");
        return true;
    };
    search.vertices = [&] { return static_cast<double>(result->mesh.positions.size()); };
    search.bytes = [&] { return largest_output(view, *result, coarser, outputs, threads, log); };
    search.error_px = [&] { return quality_as_written(view, *result, outputs, threads).duo_rmse_near_px; };
    search.texture = texture_limits(view, config, outputs);
    search.texture_bytes = [&](const TextureChoice& texture) {
        return texture_bytes(view, *result, texture);
    };
    search.use_texture = [&](const TextureChoice& texture) {
        config.exporting = with_texture(config.exporting, texture);
        if (result) result->config.exporting = with_texture(result->config.exporting, texture);
        log.decide("budget: " + text_of(texture));
    };
    const BudgetResult found = fit_budget(config.budget, search);
    result->budget = found;
    result->budget.tolerance_px = result->config.exporting.tolerance_px;
    log.decide("budget " + found.kind + ": " + fixed(found.reached, 3) + " of " + fixed(found.limit, 3) +
               " reached in " + std::to_string(found.solves) + " solves");
    return std::move(*result);
}

}  // namespace

DensityMap density_of(const DisparityMap& disparity, const stages::DensityConfig& config, int threads,
                      RunLog& log) {
    DensityMap density = stages::compute_density(disparity, config, threads);
    const auto count_of = [&](const auto& counted) {
        return std::ranges::count_if(disparity.values,
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
            add_other_views(result, view, config, threads, log);
        tell_filled(result.mesh, view.disparity, config.exporting.provenance);
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

SurfaceResult meet_budget(const LeftView& view, const config::Config& given,
                          const std::vector<fs::path>& outputs, Backend& backend, RunLog& log) {
    try {
        return search_spacing(view, given, outputs, backend, log);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::usage || given.surface.views == SurfaceViews::left) throw;
    }
    config::Config left_only = given;
    left_only.surface.views = SurfaceViews::left;
    SurfaceResult result = search_spacing(view, left_only, outputs, backend, log);
    log.warn(
        "the budget has no room for what the left camera does not see; the mesh is of its view only "
        "(surface.views=left)");
    return result;
}

}  // namespace hexrelief::job
