// Solves the tiles of a plan, each by itself, and runs work on several tiles at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "mesher/tiles/lattice_tiles.h"
#include "mesher/tiles/tile_surface.h"
#include "pipeline/job/backend.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct SolveSettings {
    int threads = 1;           // of all jobs together
    int jobs = 0;              // tiles at a time; 0 = one per thread, as far as memory allows
    std::uint64_t memory = 0;  // bytes for all jobs together; 0 = memory_to_use()
};

struct SolveObserver {
    // Called when a tile has ended, by one thread at a time; may be empty. failure: one line, or empty;
    // exit_code: of a failure.
    std::function<void(const TileNumber& tile, const std::string& failure, int exit_code)> ended;
};

// Solves tiles of the finest level. Writes tile_file()'s files of each tile, all or none: .mesh (corners,
// triangles and seam edges, tile_files.h), .glb (the mesh in space; none if the tile is empty) and, as the
// last, .json, the report. A tile that fails is reported and left out; the others go on. The same bytes in
// any order, for any number of threads and jobs, on any backend. Throws Error(input) if the coarse lattice
// is not the plan's.
void solve_tiles(const TilePlan& plan, const std::vector<TileNumber>& tiles, job::Backend& backend,
                 const SolveSettings& settings, const SolveObserver& observer);

// Returns the estimated number of bytes that solving a tile takes.
std::uint64_t tile_memory(const TilePlan& plan);

// The functions that balance and cut; any number of threads may call them.
struct TileWorkers {
    int threads = 1;  // of all jobs together
    mesh_tiles::BalancePatch balance;
    mesh_tiles::CutMesh cut;
};

// Returns workers that use the backend: one caller at a time on a device, each caller's thread on the CPU.
TileWorkers workers_of(job::Backend& backend, int threads);

// Makes the process keep the memory of freed windows for the next ones, for the rest of its life: sixteen
// threads would wait for each other if each took fresh pages from the system.
void keep_freed_memory();

// Calls work(0) ... work(count - 1), `jobs` at a time, in any order; rethrows what one of them threw.
void do_jobs(std::size_t count, int jobs, const std::function<void(std::size_t)>& work);

// As do_jobs(), for jobs that need others' results: job k begins when all jobs that name it in needed_by are
// done. needed_by[k] > k, or kNeededByNone. Of the jobs that may begin, the first goes first.
inline constexpr std::size_t kNeededByNone = SIZE_MAX;
void do_jobs_in_turn(const std::vector<std::size_t>& needed_by, int jobs,
                     const std::function<void(std::size_t)>& work);

}  // namespace hexrelief::tiles
