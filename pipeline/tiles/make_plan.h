// Makes a plan: the coarse lattice of a whole map, and the seams between its tiles.
#pragma once

#include <filesystem>

#include "pipeline/job/backend.h"
#include "pipeline/job/run_log.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct PlanRequest {
    std::filesystem::path map, color, folder;  // color may be empty
    std::optional<windows::RawMapLayout> raw;
    int tile_vertices = 512;  // along a side
    config::Config config;    // checked and complete
};

// Makes a plan and writes its folder, all files or none, plan.json last. Memory: what solve_mesh() takes for
// the map shrunk by TilePlan::shrunk_by, and one seam across the map. The result is the same for any number
// of threads and on any backend. Throws Error(usage) for settings that tiles do not support; Error(input) as
// PlannedMap does, if nothing is foreground, and if the picture does not fit the map.
TilePlan make_plan(const PlanRequest& request, const job::Backend& backend, int threads, job::RunLog& log);

}  // namespace hexrelief::tiles
