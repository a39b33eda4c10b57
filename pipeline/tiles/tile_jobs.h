// Work on tiles, several at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "mesher/tiles/lattice_tiles.h"
#include "mesher/tiles/tile_surface.h"
#include "pipeline/job/backend.h"

namespace hexrelief {

// What balances and cuts: any number of threads may call.
struct TileWorkers {
    int threads = 1;  // of all jobs together
    BalancePatch balance;
    CutMesh cut;
};

// A device is one caller's at a time; the CPU works on the caller's thread.
TileWorkers workers_of(Backend& backend, int threads);

// From now on the process keeps the memory that windows of maps were in for the next windows: sixteen threads
// wait for each other where each takes fresh pages from the system.
void keep_freed_memory();

// work(0) ... work(count - 1), `jobs` at a time, in any order; throws what one of them threw.
void do_jobs(std::size_t count, int jobs, const std::function<void(std::size_t)>& work);

// The same for jobs of which some need others' results: each begins when all that name it in needed_by are
// done. needed_by[k] > k, or kNeededByNone. Of those that may begin, the first goes first.
inline constexpr std::size_t kNeededByNone = SIZE_MAX;
void do_jobs_in_turn(const std::vector<std::size_t>& needed_by, int jobs,
                     const std::function<void(std::size_t)>& work);

}  // namespace hexrelief
