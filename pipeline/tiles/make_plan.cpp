#include "pipeline/tiles/make_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "mesher/som/level_plan.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/tiles/planned_map.h"
#include "pipeline/tiles/solve_tiles.h"
#include "pipeline/tiles/tile_files.h"

namespace hexrelief::tiles {
namespace {

// Most pixels on which the coarse lattice is solved.
constexpr long long kCoarsePixels = 1 << 28;

// Row seams are solved at the same time as long as their total length is at most this.
constexpr int kRowSeamPixels = 1 << 17;

void check_settings(const config::Config& config) {
    const auto refuse = [](const std::string& key, const std::string& why) {
        throw Error(ErrorKind::usage, key + ": " + why + "; tiles are solved apart");
    };
    if (config.mesh.method != MeshMethod::cellular) refuse("mesh.method", "must be cellular");
    if (config.mesh.border == MeshBorder::free) refuse("mesh.border", "must be fit or slide");
    if (!config.mesh.balance.enabled) refuse("mesh.balance.enabled", "must be true");
    if (config.density.detail > 0) refuse("density.detail", "must be 0, because it depends on the whole map");
    if (config.surface.silhouette_rounds > 0) refuse("surface.silhouette_rounds", "must be 0");
    if (config.exporting.lod > 1)
        refuse("export.lod", "must be 1, because 'hexrelief tiles merge' makes levels of detail");
    const config::BudgetConfig& budget = config.budget;
    if (budget.vertices > 0 || budget.max_bytes > 0 || budget.max_error_px > 0)
        refuse("budget", "no limit can be given; give mesh.spacing_px");
}

// Returns the sums of the density over squares of shrunk_by x shrunk_by px.
DensityMap shrunk_density(const TilePlan& plan, const PlannedMap& map, int threads) {
    constexpr int kWindow_px = 1024;
    const int by = plan.shrunk_by;
    DensityMap shrunk{
        (plan.width + by - 1) / by, (plan.height + by - 1) / by, {}, plan.density.background_px};
    shrunk.values.resize(static_cast<std::size_t>(shrunk.width) * shrunk.height);
    const int side = std::max(kWindow_px, by), across = (plan.width + side - 1) / side,
              down = (plan.height + side - 1) / side;
    do_jobs(static_cast<std::size_t>(across) * down, threads, [&](std::size_t k) {
        files::wait_if_interrupted();
        const int left = static_cast<int>(k) % across * side, top = static_cast<int>(k) / across * side;
        const DensityMap fine = stages::density_at_scale(
            map.read({left, top, std::min(side, plan.width - left), std::min(side, plan.height - top)}),
            plan.density, plan.config.density);
        for (int y = 0; y < fine.height; ++y) {
            float* const row = &shrunk.values[static_cast<std::size_t>((top + y) / by) * shrunk.width];
            for (int x = 0; x < fine.width; ++x) row[(left + x) / by] += fine.at(x, y);
        }
    });
    return shrunk;
}

// Returns the largest power of two that keeps positions within tolerance_px at the nearest disparity; a
// larger one if the farthest positions would otherwise be too many steps away for a float.
double grid_step(const TilePlan& plan) {
    const Calibration& c = plan.calibration;
    const double depth = c.focal_px * c.baseline_m, near = depth / (plan.nearest_px + c.doffs_px),
                 least = std::max(plan.farthest_px, plan.density.background_px) + c.doffs_px,
                 far = least > 0 ? depth / least : near;
    const double aside = std::max({std::abs(c.cx), std::abs(plan.width - c.cx), std::abs(c.cy),
                                   std::abs(plan.height - c.cy)}) /
                         c.focal_px;
    // The error in px of half a step, across and in disparity.
    const double px_of_step = 0.5 * std::max(c.focal_px / near * (1 + aside), depth / (near * near));
    const mesh_tiles::LatticeTiling tiling = plan.tiling();
    const double tile_px =
        1.5 * std::max(double(plan.width) / tiling.across(), double(plan.height) / tiling.down());
    const double widest = std::max(tile_px / c.focal_px * far + aside * (far - near), far - near);
    const double step = std::max(plan.config.exporting.tolerance_px / px_of_step, widest / (1 << 22));
    return std::exp2(std::floor(std::log2(step)));
}

Calibration camera_of_map(const TilePlan& plan, job::RunLog& log) {
    const job::ViewSize size{plan.width, plan.height};
    const job::ResolvedCalibration resolved =
        job::resolve_calibration({plan.config.input.calibration, size, size, nullptr, plan.color.path});
    for (const std::string& warning : resolved.warnings) log.warn(warning);
    if (const std::string missing = job::missing_for_metres(resolved); !missing.empty()) log.warn(missing);
    Calibration camera = resolved.calibration;
    const auto rounded = [](double px) {
        return std::floor(px * mesh_tiles::kPlacesPerPixel + 0.5) / mesh_tiles::kPlacesPerPixel;
    };
    camera.cx = rounded(camera.cx);
    camera.cy = rounded(camera.cy);
    return camera;
}

// The range of the disparities above 0; nearest is below farthest if there are none.
struct Range {
    float nearest = 0, farthest = std::numeric_limits<float>::max();

    void include(const Range& other) {
        nearest = std::max(nearest, other.nearest);
        farthest = std::min(farthest, other.farthest);
    }
};

Range range_of(const stages::MapWindow& window) {
    Range range;
    for (int y = 0; y < window.height; ++y)
        for (const float d : std::span(window.row(y), static_cast<std::size_t>(window.width)))
            if (DisparityMap::known(d) && d > 0) range.include({d, d});
    return range;
}

void find_scale(const PlannedMap& map, int threads, TilePlan& plan) {
    const stages::MapInStrips strips = map.strips(threads);
    std::vector<Range> ranges(static_cast<std::size_t>(strips.strips));
    bool is_first = true;
    const auto read = [&](const auto& take) {
        strips.read([&](int strip, const stages::MapWindow& window) {
            take(strip, window);
            if (is_first) ranges[static_cast<std::size_t>(strip)].include(range_of(window));
        });
        is_first = false;
    };
    plan.density = stages::find_density_scale({strips.strips, read}, plan.config.density);
    for (const Range& range : ranges) ranges[0].include(range);
    plan.nearest_px = ranges[0].nearest;
    if (plan.nearest_px > 0) plan.farthest_px = ranges[0].farthest;
    if (!(plan.nearest_px > 0) || plan.nearest_px < plan.density.background_px)
        throw Error(ErrorKind::input,
                    plan.map.path.string() +
                        ": nothing is left to mesh: no known disparity above 0 and above the background");
}

void lay_lattice(const PlanRequest& request, TilePlan& plan) {
    const auto lattice = som::lattice_size(plan.width, plan.height, plan.config.mesh.spacing_px);
    plan.columns = lattice.columns;
    plan.rows = lattice.rows;
    plan.tile_spacings = request.tile_vertices;
    const auto pixels = [&] {
        return (static_cast<long long>(plan.width) / plan.shrunk_by) * (plan.height / plan.shrunk_by);
    };
    // A map so small that half of it could not hold a lattice is not shrunk.
    const int half = std::min(plan.width, plan.height) / 2;
    plan.shrunk_by = half < 3 * plan.config.mesh.spacing_px ? 1 : 2;
    while (pixels() > kCoarsePixels) plan.shrunk_by *= 2;
}

// Solves and writes the seams. Those of rows are as long as the map is wide: few at a time, each by several
// threads. Those of columns are solved as many at a time as there are threads.
void write_seams(const TilePlan& plan, const PlannedMap& map, const mesh_tiles::CoarseLattice& coarse,
                 const TileWorkers& workers, files::OutputSet& files, job::RunLog& log) {
    const mesh_tiles::LatticeTiling tiling = plan.tiling();
    const auto density_by = [&](int threads) -> mesh_tiles::DensityOfWindow {
        return [&, threads](const mesh_tiles::MapRect& window) {
            return stages::density_at_scale(map.read(window, threads), plan.density, plan.config.density,
                                            threads);
        };
    };
    const int row_jobs = std::clamp(kRowSeamPixels / plan.width, 1, std::min(4, workers.threads)),
              row_threads = workers.threads / row_jobs;
    const mesh_tiles::DensityOfWindow by_some = density_by(row_threads), by_one = density_by(1);
    const BalanceConfig& config = plan.config.mesh.balance;
    const mesh_tiles::TileSolver of_rows(tiling, coarse, config, by_some, row_threads, workers.balance),
        of_columns(tiling, coarse, config, by_one, 1, workers.balance);
    std::vector<mesh_tiles::Seam> rows(static_cast<std::size_t>(tiling.down()) + 1);
    log.stage("row seams", [&] {
        do_jobs(static_cast<std::size_t>(tiling.down()) - 1, row_jobs, [&](std::size_t k) {
            files::wait_if_interrupted();
            rows[k + 1] = of_rows.row_seam(static_cast<int>(k) + 1);
        });
    });
    for (int j = 1; j < tiling.down(); ++j)
        files.write(row_seam_file(plan, j), seam_bytes(rows[static_cast<std::size_t>(j)]));
    const auto row_seam = [&](int j) {
        return j > 0 && j < tiling.down() ? &rows[static_cast<std::size_t>(j)] : nullptr;
    };
    const int inner = tiling.across() - 1;
    std::vector<std::vector<std::uint8_t>> columns(static_cast<std::size_t>(inner) * tiling.down());
    log.stage("column seams", [&] {
        do_jobs(columns.size(), workers.threads, [&](std::size_t k) {
            files::wait_if_interrupted();
            const int i = static_cast<int>(k) % inner + 1, j = static_cast<int>(k) / inner;
            columns[k] = seam_bytes(of_columns.column_seam(i, j, row_seam(j), row_seam(j + 1)));
        });
    });
    for (std::size_t k = 0; k < columns.size(); ++k)
        files.write(column_seam_file(plan, static_cast<int>(k) % inner + 1, static_cast<int>(k) / inner),
                    columns[k]);
}

}  // namespace

TilePlan make_plan(const PlanRequest& request, job::Backend& backend, job::RunLog& log) {
    const int threads = backend.threads();
    check_settings(request.config);
    keep_freed_memory();
    TilePlan plan;
    plan.folder = request.folder;
    plan.config = request.config;
    plan.raw = request.raw;
    plan.map = planned_file(request.map);
    if (!request.color.empty()) plan.color = planned_file(request.color);
    const PlannedMap map(plan, false);
    plan.width = map.width();
    plan.height = map.height();
    plan.calibration = camera_of_map(plan, log);
    plan.config.input.calibration.second_file.clear();
    plan.config.input.calibration.file.clear();  // the plan contains the file's values
    lay_lattice(request, plan);
    log.stage("density", [&] { find_scale(map, threads, plan); });
    plan.grid_step_m = grid_step(plan);

    mesh_tiles::CoarseLattice coarse{{}, plan.shrunk_by, plan.width, plan.height};
    const DensityMap shrunk = log.stage("shrunk density", [&] { return shrunk_density(plan, map, threads); });
    coarse.mesh = log.stage("coarse lattice", [&] {
        return backend.solve_mesh(shrunk, plan.config.mesh, [&](double share) { log.progress(share); });
    });
    files::OutputSet files;
    files.write(coarse_file(plan), lattice_bytes(coarse.mesh));
    const TileWorkers workers = workers_of(backend, threads);
    write_seams(plan, map, coarse, workers, files, log);
    write_plan(plan, files);
    files.commit();
    return plan;
}

}  // namespace hexrelief::tiles
