// Stage: the far end of a matched map, moved to where matches support it.
#pragma once

#include <optional>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// The farthest plane of a matched scene.
struct Backdrop {
    float disparity_px = 0;
    double moved_share = 0;  // share of the map's known pixels that were farther
};

// Raises the smaller disparities of a matched map to that of its backdrop, which lies `farthest` (> 0) times
// as far as the scene. The scene ends where all but 1 % of the matched pixels are nearer, at most at ten
// times their median depth. Matches within 1 px of min_px, the least disparity searched, do not count: what
// has no match, or lies beyond the range, ends there. doffs_px as in Calibration: depth is proportional to 1
// / (d + doffs_px). Returns nothing and changes nothing if fewer than 100 matches count.
std::optional<Backdrop> put_backdrop(DisparityMap& map, int min_px, double doffs_px, double farthest);

}  // namespace hexrelief::stages
