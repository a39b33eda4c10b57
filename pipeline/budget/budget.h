// A budget instead of a spacing: vertices, bytes or error.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "pipeline/budget/texture_choice.h"
#include "pipeline/config/config.h"

namespace hexrelief {

// What the search asks of a run.
struct BudgetJob {
    double start_px = 6, least_px = 2, most_px = 256;  // of the lattice spacing
    double tolerance_px = 0.1;                         // of compressed positions
    bool compressed = false;                           // the tolerance changes the files
    // Makes mesh and surface; false where no triangle is left.
    std::function<bool(double spacing_px, double tolerance_px)> solve;
    // Of what was last solved. bytes: of the largest output with the files beside it. error: of both views
    // (SurfaceQuality::duo_rmse_near_px), of the positions as written.
    std::function<double()> vertices, bytes, error_px;
    // Where a limit on bytes may change the texture: its bytes on the mesh last solved, and what makes it the
    // one that is written.
    std::optional<TextureLimits> texture;
    std::function<double(const TextureChoice&)> texture_bytes;
    std::function<void(const TextureChoice&)> use_texture;
};

// True where a limit is given.
bool has_budget(const BudgetConfig& budget);

struct BudgetResult {
    std::string kind;  // "vertices", "max_bytes", "max_error_px"; empty = no budget
    double limit = 0, reached = 0;
    double spacing_px = 0, tolerance_px = 0;
    int solves = 0;
    std::optional<TextureChoice> texture;  // where it was chosen
};

// Solves until the one limit that the configuration gives is kept, as in search_spacing(); the last call of
// solve() is at the result. For bytes coarser tolerances are tried as well, and the least error wins. The
// texture gets at most half of the bytes, as choose_texture() finds it; where no mesh fits beside that, a
// quarter, then the smallest texture of all. The mesh has the rest. Deterministic. Throws Error(usage) where
// the limit is out of reach.
BudgetResult fit_budget(const BudgetConfig& budget, const BudgetJob& job);

}  // namespace hexrelief
