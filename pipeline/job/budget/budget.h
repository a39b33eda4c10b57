// Searches for the lattice spacing that keeps a budget of vertices, bytes or error.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/config/config.h"

namespace hexrelief::job {

struct SpacingSearch {
    double limit = 0;  // upper limit of the figure; > 0
    // Rough slope of the figure over the spacing, both as logarithms; its sign must be right.
    double slope = -2;
    double start_px = 6;  // tried first
    double least_px = 2;  // range of the spacing
    double most_px = 256;
};

struct SpacingFound {
    double spacing_px = 0;
    double value = 0;  // the figure at this spacing, <= limit
    int solves = 0;    // all calls of the figure
};

// Returns the figure at a spacing (> 0), or nothing if no mesh is left, which counts as too coarse.
using SpacingFigure = std::function<std::optional<double>(double)>;

// Finds the best spacing whose figure keeps the limit: the finest one if the figure falls with the
// spacing (slope < 0: vertices, bytes), the coarsest if it grows (slope > 0: error). Spacings are
// multiples of 0.01 px. The search ends after 12 solves, or when the figure is within 3 % of the limit or
// the spacing is bracketed to 1 %. Returns nothing if no spacing tried keeps the limit; `nearest` then
// holds the one that came nearest.
std::optional<SpacingFound> search_spacing(const SpacingSearch& search, const SpacingFigure& figure,
                                           SpacingFound& nearest);

struct TextureChoice {
    int max_px = 0;  // of the longest side; 0 = unlimited
    int quality = 90;
};

struct TextureLimits {
    TextureChoice configured;
    int longest_px = 0;  // longest side of the configured texture
    bool may_shrink = true, may_lose_quality = true;
};

// Returns the choices from the configured texture on, each with fewer bytes than the one before: at the same
// size in steps of 10 down to a quality of 50, then with sides 0.71 times as long each time, at qualities 70
// and 50, down to 32 px.
std::vector<TextureChoice> texture_choices(const TextureLimits& limits);

// Returns the first choice that takes at most `share` of `max_bytes`; the last one if none does. Calls
// bytes() for some choices only; sizes are assumed to fall from one choice to the next.
TextureChoice choose_texture(const TextureLimits& limits, double max_bytes, double share,
                             const std::function<double(const TextureChoice&)>& bytes);

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
