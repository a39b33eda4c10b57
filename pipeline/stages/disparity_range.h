// Estimates the range of a pair's disparities, and ends its map there.
#pragma once

#include <cstddef>
#include <optional>

#include "pipeline/data/disparity_map.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief::stages {

// The origin of the searched range: the pair itself, the configuration, or the calibration's ndisp.
enum class RangeOrigin { chosen, given, ndisp };

struct ReducedPair {
    double scale = 1;  // columns of the full pair per column of the reduced one
    StereoPair pair;
};

// The disparities that both views of a reduced pair agree on.
struct SmallMatch {
    ReducedPair small;
    int min_px = 0;  // in px of the reduced pair: the map's disparities count from here
    matching::MatchedMap map;
};

inline constexpr int kCoarseColumns = 160, kFineColumns = 320;

// Matches the pair at so many columns (or at its own width if that is less), from min_px on over its whole
// width. Both images must have one size and at least 16 columns.
SmallMatch match_coarsely(const StereoPair& pair, int min_px, int threads, int columns = kCoarseColumns);
// Matches it from min_px to max_px.
SmallMatch match_between(const StereoPair& pair, int min_px, int max_px, int threads, int columns);

// Chooses how many disparities from min_px on cover the pair: a multiple of 16, at most the width. The pair
// is matched again at a larger size, over somewhat more than the range that the coarse match found. The
// largest disparity that more than a few pixels have in both views is then widened by a margin: a wider range
// costs time and gives false matches, a narrower one loses near surfaces. Returns a quarter of the width if
// next to nothing matches.
int choose_num_disparities(const StereoPair& pair, const SmallMatch& coarse, int min_px, int threads);

// Returns the disparity, in px of the full pair (a multiple of 1/16), below which small patches of matches
// are not trusted: the least disparity that more than a few pixels of the coarse match have, less a margin.
// NaN if next to nothing matches. The reason: pixels that only one camera sees, beside the frame or behind a
// near surface, may match anything, often something far.
double farthest_disparity_px(const SmallMatch& coarse);

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

// Moves what is nearer than nearest_px to the surface around it: each connected part takes the median of the
// disparities along its border that are not nearer; nearest_px if there are none. Returns the number of
// pixels.
std::size_t press_near(DisparityMap& map, double nearest_px);

}  // namespace hexrelief::stages
