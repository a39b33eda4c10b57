// Makes a plan: the coarse lattice of a whole map, and the seams between its tiles.
#pragma once

#include <filesystem>

#include "pipeline/job/backend.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct PlanRequest {
    std::filesystem::path map, color, folder;  // color may be empty
    std::optional<readers::RawMapLayout> raw;
    int tile_vertices = 512;  // along a side
    config::Config config;    // checked and complete
};

// Writes the plan's folder, all files or none, with plan.json as the last. Memory: that of solve_mesh() for
// the map shrunk by TilePlan::shrunk_by, and of a seam across the map. The same bytes for any number of
// threads and on any backend. Throws Error(usage) for settings that tiles cannot have; Error(input) as
// PlannedMap, if nothing is foreground, and if the picture does not fit the map.
TilePlan make_plan(const PlanRequest& request, job::Backend& backend, job::RunLog& log);

}  // namespace hexrelief::tiles
