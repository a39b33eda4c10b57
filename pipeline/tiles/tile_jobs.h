// Runs work on several tiles at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "mesher/tiles/lattice_tiles.h"
#include "mesher/tiles/tile_surface.h"
#include "pipeline/job/backend.h"

namespace hexrelief::tiles {

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
