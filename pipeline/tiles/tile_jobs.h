// Work on tiles, several at a time.
#pragma once

#include <cstddef>
#include <functional>

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
TileWorkers workers_of(const Backend& backend, int threads);

// From now on the process keeps the memory that windows of maps were in for the next windows: sixteen threads
// wait for each other where each takes fresh pages from the system.
void keep_freed_memory();

// work(0) ... work(count - 1), `jobs` at a time, in any order; throws what one of them threw.
void do_jobs(std::size_t count, int jobs, const std::function<void(std::size_t)>& work);

}  // namespace hexrelief
