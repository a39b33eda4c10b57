#include "pipeline/tiles/solve_tiles.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <set>

#include "pipeline/base/thread_pool.h"
#include "pipeline/batch/worker.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/stages/surface_raster.h"
#include "pipeline/tiles/planned_map.h"
#include "pipeline/tiles/tile_files.h"
#include "pipeline/tiles/tile_output.h"

namespace hexrelief::tiles {
namespace {

namespace fs = std::filesystem;

// Measured maximum, on the CPU.
constexpr std::uint64_t kBytesPerPixel = 110;

// The data that the jobs of a process share.
struct SolveContext {
    const TilePlan& plan;
    const TileWorkers& workers;
    int threads;  // of one job
    mesh_tiles::LatticeTiling tiling;
    PlannedMap map;
    mesh_tiles::CoarseLattice coarse;
    mesh_tiles::DensityOfWindow density;
    mesh_tiles::TileSolver solver;

    SolveContext(const TilePlan& of, const TileWorkers& with, int threads_of_job)
        : plan(of),
          workers(with),
          threads(threads_of_job),
          tiling(of.tiling()),
          map(of, true),
          coarse{read_lattice(coarse_file(of)), of.shrunk_by, of.width, of.height},
          density([this](const mesh_tiles::MapRect& window) {
              return stages::density_at_scale(map.read(window), plan.density, plan.config.density);
          }),
          solver(tiling, coarse, plan.config.mesh.balance, density, threads, workers.balance) {}
};

mesh_tiles::LatticeBlock solved_block(const SolveContext& context, const TileNumber& tile) {
    const TilePlan& plan = context.plan;
    std::array<std::unique_ptr<mesh_tiles::Seam>, 4> seams;  // above, below, left, right
    const auto read = [&](std::size_t k, bool is_there, const fs::path& path) {
        if (!is_there) return;
        check_planned_file(plan, path);
        seams[k] = std::make_unique<mesh_tiles::Seam>(read_seam(path));
    };
    const int i = tile.i, j = tile.j;
    read(0, j > 0, row_seam_file(plan, j));
    read(1, j + 1 < context.tiling.down(), row_seam_file(plan, j + 1));
    read(2, i > 0, column_seam_file(plan, i, j));
    read(3, i + 1 < context.tiling.across(), column_seam_file(plan, i + 1, j));
    return context.solver.tile(i, j, {seams[0].get(), seams[1].get(), seams[2].get(), seams[3].get()});
}

// The mean over this many rows of pixels is accurate enough; all rows would take longer than the rest
// of a large tile.
constexpr int kMeasuredRows = 192;

// Measures over the foreground pixels that the surface covers, in about kMeasuredRows rows, or in all if
// there is none in these.
void measure_error(const TilePlan& plan, const SurfaceMesh& mesh, const DisparityMap& map,
                   TileReport& report) {
    stages::View view{{}, &mesh.triangles, map.width, map.height};
    for (std::size_t v = 0; v < mesh.image_points.size(); ++v)
        view.points.push_back({mesh.image_points[v].x, mesh.image_points[v].y, mesh.disparities[v]});
    const Calibration& c = plan.calibration;
    double pixels = 0, squares_px = 0, squares_m = 0;
    const auto measure = [&](const stages::PixelRun& run) {
        const float* const known = map.values.data() + static_cast<std::size_t>(run.y) * map.width + run.x;
        for (int i = 0; i < run.count; ++i) {
            const double d = known[i], seen = run.disparity(i);
            const double nearness = d + c.doffs_px, nearness_seen = seen + c.doffs_px;
            if (!DisparityMap::known(known[i]) || !(d > 0) || d < plan.density.background_px ||
                !(nearness > 0) || !(nearness_seen > 0))
                continue;
            const double px = seen - d, m = c.focal_px * c.baseline_m * px / (nearness * nearness_seen);
            squares_px += px * px;
            squares_m += m * m;
            ++pixels;
        }
    };
    const int row_step = std::max(1, map.height / kMeasuredRows);
    stages::scan_pixels(view, row_step, measure);
    if (pixels == 0 && row_step > 1) stages::scan_pixels(view, 1, measure);
    if (pixels == 0) return;
    report.error_px = std::sqrt(squares_px / pixels);
    report.error_m = std::sqrt(squares_m / pixels);
}

void solve_tile(const SolveContext& context, const TileNumber& tile) {
    const TilePlan& plan = context.plan;
    const mesh_tiles::LatticeBlock block = solved_block(context, tile);
    const mesh_tiles::MapRect window =
        mesh_tiles::window_of(block, mesh_tiles::kTileMargin_px, plan.width, plan.height);
    const DisparityMap map = context.map.read(window);
    Image color;
    if (const readers::PictureWindows* const picture = context.map.picture())
        color = picture->read(window.x, window.y, window.width, window.height);
    mesh_tiles::TileSurfaceInput input{window, &map, plan.density.background_px, {}};
    input.whole.cell_px = double(plan.width) * plan.height / (double(plan.columns) * plan.rows);
    input.whole.nearest_px = plan.nearest_px;
    input.whole.farthest_px = plan.farthest_px;
    mesh_tiles::TileMesh mesh = mesh_tiles::tile_mesh_of(
        mesh_tiles::cut_tile(context.tiling, tile.i, tile.j, block, input, plan.config.surface,
                             context.threads, context.workers.cut),
        window);
    join_crumbs(mesh, window, input.whole.cell_px);
    drop_specks(mesh, plan.config.surface.min_component);
    TileReport report;
    const TileScene scene = tile_scene(plan, mesh, window);
    if (!scene.mesh.empty()) measure_error(plan, scene.mesh, map, report);
    write_tile(plan, tile, mesh, scene, color.empty() ? nullptr : &color, context.threads, report);
}

int jobs_of(const TilePlan& plan, const SolveSettings& settings, std::size_t tiles) {
    if (settings.jobs > 0) return settings.jobs;
    const std::uint64_t memory = settings.memory > 0 ? settings.memory : batch::memory_to_use();
    const std::uint64_t fitting = std::max<std::uint64_t>(1, memory / tile_memory(plan));
    return static_cast<int>(std::min({fitting, std::uint64_t(settings.threads), std::uint64_t(tiles)}));
}

int pool_size(std::size_t count, int jobs) {
    return static_cast<int>(std::clamp<std::size_t>(count, 1, static_cast<std::size_t>(std::max(1, jobs))));
}

}  // namespace

std::uint64_t tile_memory(const TilePlan& plan) {
    const mesh_tiles::LatticeTiling tiling = plan.tiling();
    const auto side = [](int px, int tiles) { return 1.3 * px / tiles + 4 * mesh_tiles::kTileMargin_px; };
    return static_cast<std::uint64_t>(side(plan.width, tiling.across()) * side(plan.height, tiling.down())) *
           kBytesPerPixel;
}

void solve_tiles(const TilePlan& plan, const std::vector<TileNumber>& tiles, job::Backend& backend,
                 const SolveSettings& settings, const SolveObserver& observer) {
    if (tiles.empty()) return;
    check_planned_file(plan, coarse_file(plan));
    keep_freed_memory();
    const int jobs = jobs_of(plan, settings, tiles.size());
    const TileWorkers workers = workers_of(backend, settings.threads);
    const SolveContext context(plan, workers, std::max(1, settings.threads / jobs));
    std::mutex turn;
    do_jobs(tiles.size(), jobs, [&](std::size_t k) {
        files::wait_if_interrupted();
        batch::UnitResult result;
        try {
            solve_tile(context, tiles[k]);
        } catch (...) {
            result = batch::result_of_exception();
        }
        const std::lock_guard lock(turn);
        if (observer.ended) observer.ended(tiles[k], result.message, result.exit_code);
    });
}

TileWorkers workers_of(job::Backend& backend, int threads) {
    if (backend.name() == "cpu") return {threads, balance::balance_patch, surface::cut_disparity_mesh};
    const auto turn = std::make_shared<std::mutex>();
    return {threads,
            [&backend, turn](const DensityMap& density, const BalanceConfig& config, int,
                             balance::LatticePatch& patch) {
                const std::lock_guard lock(*turn);
                backend.balance_patch(density, config, patch);
            },
            [&backend, turn](const surface::DisparityMeshInput& input, const SurfaceConfig& config, int) {
                const std::lock_guard lock(*turn);
                return backend.cut_disparity_mesh(input, config);
            }};
}

void keep_freed_memory() {
    mallopt(M_ARENA_MAX, 1);  // other arenas hold 64 MiB, in which a window leaves no room for the next
    mallopt(M_MMAP_THRESHOLD, 1 << 28);
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_TOP_PAD, 1 << 26);
}

void do_jobs(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
    ThreadPool pool(pool_size(count, jobs));
    std::atomic<std::size_t> next{0};
    pool.run([&](int) {
        for (std::size_t k = next++; k < count; k = next++) work(k);
    });
}

void do_jobs_in_turn(const std::vector<std::size_t>& needed_by, int jobs,
                     const std::function<void(std::size_t)>& work) {
    const std::size_t count = needed_by.size();
    std::vector<std::size_t> waits_for(count);
    for (const std::size_t other : needed_by)
        if (other != kNeededByNone) ++waits_for[other];
    std::set<std::size_t> ready;
    for (std::size_t k = 0; k < count; ++k)
        if (waits_for[k] == 0) ready.insert(ready.end(), k);
    std::mutex turn;
    std::condition_variable changed;
    std::size_t not_begun = count;
    ThreadPool(pool_size(count, jobs)).run([&](int) {
        std::unique_lock lock(turn);
        while (not_begun > 0) {
            if (ready.empty()) {
                changed.wait(lock);
                continue;
            }
            const std::size_t k = *ready.begin();
            ready.erase(ready.begin());
            --not_begun;
            lock.unlock();
            try {
                work(k);
            } catch (...) {
                lock.lock();
                not_begun = 0;
                changed.notify_all();
                throw;
            }
            lock.lock();
            if (needed_by[k] != kNeededByNone && --waits_for[needed_by[k]] == 0) ready.insert(needed_by[k]);
            changed.notify_all();
        }
    });
}

}  // namespace hexrelief::tiles
