#include "pipeline/job/tolerance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "exporters/compression/quantized_streams.h"
#include "exporters/exporter.h"
#include "exporters/images/texture.h"
#include "pipeline/data/bounds.h"
#include "pipeline/stages/surface_quality.h"

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

double tolerance_for(const exporters::ExportConfig& config, const SurfaceMesh& surface,
                     const DisparityMap& map, float background_px, int threads) {
    if (!(config.tolerance_share > 0)) return config.tolerance_px;
    const double error_px =
        stages::measure_surface_quality(surface, map, background_px, threads).flat_rmse_px;
    // rounded, because machines may differ in the last bits of the measured error
    const double wanted_px =
        std::max(kLeastTolerance_px, 1e-3 * static_cast<long long>(1e3 * config.tolerance_share * error_px));
    return std::min(config.tolerance_px, wanted_px);
}

bool is_compressed(const fs::path& path, const exporters::ExportConfig& config) {
    return exporters::export_format(path).compression_in(config) != exporters::Compression::none;
}

SurfaceMesh as_written(const exporters::Scene& scene, const exporters::ExportConfig& config,
                       const std::vector<fs::path>& outputs) {
    const auto path = std::find_if(outputs.begin(), outputs.end(),
                                   [&](const fs::path& output) { return is_compressed(output, config); });
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

}  // namespace hexrelief::job
