// Searches for the lattice spacing that keeps a budget of vertices, bytes or error.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "pipeline/config/config.h"
#include "pipeline/job/budget/texture_choice.h"

namespace hexrelief::job {

// The functions and ranges by which the search makes meshes.
struct BudgetJob {
    double start_px = 6, least_px = 2, most_px = 256;  // of the lattice spacing
    double tolerance_px = 0.1;                         // of compressed positions
    bool compressed = false;                           // true: the tolerance changes the files
    // Makes mesh and surface; false if no triangle is left.
    std::function<bool(double spacing_px, double tolerance_px)> solve;
    // Figures of the last solved mesh. bytes: of the largest output, with the files beside it. error_px: of
    // both views (SurfaceQuality::duo_rmse_near_px), of the positions as written.
    std::function<double()> vertices, bytes, error_px;
    // Set if a limit on bytes may change the texture. texture_bytes: the size of a texture for the last
    // solved mesh; use_texture: makes it the one that is written.
    std::optional<TextureLimits> texture;
    std::function<double(const TextureChoice&)> texture_bytes;
    std::function<void(const TextureChoice&)> use_texture;
};

// True if a limit is given.
bool has_budget(const config::BudgetConfig& budget);

struct BudgetResult {
    std::string kind;  // "vertices", "max_bytes", "max_error_px"; empty = no budget
    double limit = 0, reached = 0;
    double spacing_px = 0, tolerance_px = 0;
    int solves = 0;
    std::optional<TextureChoice> texture;  // set if it was chosen here
};

// Solves until the one limit that the configuration gives is kept, by search_spacing(); the last call of
// solve() is for the result. For a limit on bytes, coarser tolerances are tried as well, and the least error
// wins. The texture gets at most half of the bytes, by choose_texture(); if no mesh fits beside it, a
// quarter, then the smallest texture of all. The mesh gets the rest. Deterministic. Throws Error(usage) if
// the limit is out of reach.
BudgetResult fit_budget(const config::BudgetConfig& budget, const BudgetJob& job);

}  // namespace hexrelief::job
