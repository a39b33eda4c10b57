// Solves the tiles of a plan, each by itself.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

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

}  // namespace hexrelief::tiles
