#include "pipeline/job/meet_budget.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "exporters/exporter.h"
#include "exporters/images/texture.h"
#include "pipeline/data/error.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/surfaces.h"

namespace hexrelief::job {
namespace {

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
    return config.draco.position_bits == 0 &&
           std::any_of(outputs.begin(), outputs.end(), [&](const fs::path& path) {
               return is_compressed(path, config) && !exporters::export_format(path).tolerance_px;
           });
}

// Returns the texture settings that the search may change: those that the configuration does not give. None
// if no output has a texture.
std::optional<TextureLimits> texture_limits(const LeftView& view, const config::Config& config,
                                            const std::vector<fs::path>& outputs) {
    const exporters::ExportConfig& exporting = config.exporting;
    const bool is_written = std::any_of(outputs.begin(), outputs.end(), [](const fs::path& path) {
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
