#include "pipeline/job/outputs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <optional>
#include <utility>

#include "exporters/compression/quantized_streams.h"
#include "exporters/exporter.h"
#include "exporters/images/image_writer.h"
#include "exporters/images/texture.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/number_text.h"
#include "pipeline/data/start_work.h"
#include "pipeline/job/pictures/drawing.h"
#include "pipeline/job/pictures/stage_pictures.h"
#include "pipeline/job/report.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

// Returns the grid that Draco makes of a fixed number of bits.
exporters::Grid<3> grid_of_bits(const SurfaceMesh& surface, int bits) {
    const Bounds bounds = bounds_of(surface.positions);
    const double step = bounds.widest_side() / ((1u << bits) - 1);
    exporters::Grid<3> grid;
    grid.origin = {bounds.low.x, bounds.low.y, bounds.low.z};
    grid.step = {step, step, step};
    for (const Vec3f& p : surface.positions) {
        const std::array<float, 3> values = {p.x, p.y, p.z};
        std::array<std::int32_t, 3> cell;
        for (int k = 0; k < 3; ++k)
            cell[k] = static_cast<std::int32_t>(std::lround((values[k] - grid.origin[k]) / step));
        grid.cells.push_back(cell);
    }
    return grid;
}

// Returns the grid of a file's positions; none if they stay floats. Draco in glTF has a step per axis; .drc
// has no transform that could hold them.
std::optional<exporters::Grid<3>> grid_of(const exporters::Scene& scene,
                                          const exporters::ExportConfig& config, const fs::path& path) {
    const exporters::ExportConfig held = exporters::config_of_file(scene, config, path);
    if (held.compression != exporters::Compression::draco)
        return exporters::position_grid(exporters::untextured_mesh(scene, held), scene.camera, held,
                                        held.compression == exporters::Compression::meshopt);
    if (held.draco.position_bits > 0) return grid_of_bits(*scene.mesh, held.draco.position_bits);
    return exporters::quantise_positions(
        *scene.mesh, *scene.camera, held.tolerance_px,
        exporters::export_format(path).compression == exporters::Compression::draco
            ? exporters::GridShape::cubic
            : exporters::GridShape::per_axis);
}

}  // namespace

bool is_compressed(const fs::path& path, const exporters::ExportConfig& config) {
    return exporters::export_format(path).compression_in(config) != exporters::Compression::none;
}

SurfaceMesh as_written(const exporters::Scene& scene, const exporters::ExportConfig& config,
                       const std::vector<fs::path>& outputs) {
    const auto path =
        std::ranges::find_if(outputs, [&](const fs::path& output) { return is_compressed(output, config); });
    if (path == outputs.end()) return *scene.mesh;
    const std::optional<exporters::Grid<3>> held = grid_of(scene, config, *path);
    if (!held) return *scene.mesh;
    const exporters::Grid<3>& grid = *held;
    const Calibration& camera = *scene.camera;
    SurfaceMesh seen;
    seen.triangles = scene.mesh->triangles;
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

exporters::Scene scene_of(const LeftView& view, const SurfaceResult& result,
                          const std::vector<SurfaceMesh>& coarser) {
    exporters::Scene scene{&result.mesh,
                           result.texture(view),
                           std::string("hexrelief ") + HEXRELIEF_VERSION,
                           extras_json(view, result),
                           &view.calibration,
                           {}};
    scene.up = view.up;
    scene.image_width = view.disparity.width;
    scene.image_height = view.disparity.height;
    scene.texture_file = view.texture_file;
    for (const SurfaceMesh& level : coarser) scene.coarser.push_back(&level);
    return scene;
}

stages::SurfaceQuality quality_as_written(const LeftView& view, const SurfaceResult& result,
                                          const std::vector<fs::path>& outputs, int threads) {
    SurfaceMesh written = as_written(scene_of(view, result, {}), result.config.exporting, outputs);
    written.triangles.resize(result.mesh.left_triangles());  // the map says nothing of other views
    const auto against = [&](const DisparityMap& map) {
        return stages::measure_surface_quality(written, map, view.density.background_px, threads);
    };
    if (!view.has_filled_holes) return against(view.disparity);
    DisparityMap supplied = view.disparity;
    for (std::size_t i = 0; i < supplied.values.size(); ++i)
        if (supplied.origins[i] == PixelOrigin::filled) supplied.values[i] = kUnknownDisparity;
    return against(supplied);
}

void tell_quality(const stages::SurfaceQuality& quality, const RunLog& log) {
    log.decide("root mean square error against the disparity map: left view " +
               fixed(quality.rmse_near_px, 3) + " px, both views " + fixed(quality.duo_rmse_near_px, 3) +
               " px, away from discontinuities " + fixed(quality.flat_rmse_px, 3) +
               " px; rubber sheets over " + fixed(100 * quality.sheet_share, 2) +
               " % of what only the right camera sees, coverage " + fixed(100 * quality.coverage, 2) + " %");
}

std::vector<OutputFile> export_all(const exporters::Scene& scene, const exporters::ExportConfig& config,
                                   const std::vector<fs::path>& paths, files::OutputSet& files,
                                   const RunLog& log) {
    std::vector<OutputFile> outputs;
    double done = 0;
    for (const fs::path& name : paths) {
        files.place(name);
        const std::size_t before = files.written().size();
        exporters::export_scene(scene, config, name, files.files());
        for (std::size_t i = before; i < files.written().size(); ++i) {
            const files::WrittenFile& file = files.written()[i];
            const std::string extension = file.path.extension().string();
            outputs.push_back(
                {file.path.string(),
                 i == before ? exporters::export_format(name).name() : extension.substr(!extension.empty()),
                 file.bytes, file.sha256});
        }
        log.progress(++done / static_cast<double>(paths.size()));
    }
    return outputs;
}

void save_stages(const LeftView& view, const SurfaceResult& result, const fs::path& folder,
                 files::OutputSet& files, int threads, const RunLog& log) {
    files.make_folder(folder);
    const StageResults results{&view.meshed,
                               &view.density,
                               &result.lattice,
                               &result.mesh,
                               view.color.empty() ? nullptr : &view.color,
                               result.texture(view),
                               &view.calibration,
                               result.config.mesh.seed,
                               threads};
    double done = 0;
    for (const fs::path& name : stage_file_names()) {
        files.files().write(folder / name, encode_stage_file(results, name));
        log.progress(++done / static_cast<double>(stage_file_names().size()));
    }
}

void save_rectified(const StereoPair& pair, const Calibration& camera, const fs::path& folder,
                    files::OutputSet& files) {
    files.make_folder(folder);
    const std::vector<fs::path>& names = rectified_file_names();
    files.files().write(folder / names[0], exporters::encode_png(pair.left));
    files.files().write(folder / names[1], exporters::encode_png(pair.right));
    std::string text = "# The camera of " + names[0].string() + " and " + names[1].string() + ".\n";
    const auto line = [&](const std::string& key, double value) {
        text += key + ": " + number_text(value, 17) + "\n";
    };
    line("focal_px", camera.focal_px);
    line("baseline_m", camera.baseline_m);
    line("cx", camera.cx);
    line("cy", camera.cy);
    line("doffs_px", camera.doffs_px);
    line("width", camera.width);
    line("height", camera.height);
    files.write(folder / names[2], text);
}

bool has_page(const std::vector<std::filesystem::path>& outputs) {
    return std::ranges::any_of(
        outputs, [](const std::filesystem::path& path) { return exporters::export_format(path).is_page; });
}

exporters::PageContent page_content(const LeftView& view, const SurfaceResult& result,
                                    const stages::SurfaceQuality& quality, int threads) {
    const HexMesh2D& lattice = result.lattice;
    std::future<Image> relief =
        start_work(threads, [&] { return render_relief(result.mesh, result.texture(view)); });
    const Image disparities = disparity_picture(view.meshed);
    exporters::PageContent page;
    const auto add = [&](const char* name, const char* label, Image image) {
        page.pictures.push_back({name, label, std::move(image)});
    };
    add("disparity", "Disparities, yellow is near", disparities);
    add("density", "Density that the lattice is adapted to", density_picture(view.density));
    add("mesh2d", "The adapted lattice",
        mesh_picture(lattice, view.color.empty() ? disparities : view.color));
    add("weights", "How equal its honeycomb cells are",
        weights_picture(quality::honeycomb_weights(lattice, view.density, threads)));

    add("relief", "The relief, seen from the side", relief.get());

    const Bounds bounds = bounds_of(result.mesh.positions);  // the camera looks along -Z
    const char* const unit = result.mesh.metric ? "m" : "relative";
    page.figures = {
        {"Nearest", -bounds.high.z, 2, unit},
        {"Farthest", -bounds.low.z, 2, unit},
        {"Of the picture meshed", 100 * quality.coverage, 1, "%"},
        {"Error, both views", quality.duo_rmse_near_px, 3, "px"},
        {"Error, left view", quality.rmse_near_px, 3, "px"},
        {"Lattice vertices", static_cast<double>(lattice.positions.size()), 0, ""},
        {"%cost", result.quality.percent_cost, 2, ""},
    };
    return page;
}

}  // namespace hexrelief::job
