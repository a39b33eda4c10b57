// The matcher's interface: from a rectified pair to disparities, by semi-global matching on census and colour
// (Hirschmueller 2008), filled, with discontinuities aligned with the left picture's colours. Callers need no
// other header of this folder. All arithmetic is in integers, or in floats that hold integers, so the result
// is the same for any number of threads, and by cuda/matching.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/refine/consistency.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching {

struct MatchingConfig {
    // left(x, y) = right(x - d, y) is tried for min_px <= d < min_px + count. count is 1..1920: planes are
    // followed beyond the range, and their disparities have to fit into 16 bits.
    DisparityRange range;
    // Penalties of a step of 1 px and of larger steps along a path: 1 <= p1 < p2 <= 16000.
    step::PathPenalties penalties;
    // Its min_px is ignored; that of `range` is used.
    ConsistencyConfig consistency;

    bool operator==(const MatchingConfig&) const = default;
};

// A matched map: row-major, top row first, width * height entries in each array.
struct MatchedMap {
    int width = 0, height = 0;
    // In 1/16 px above range.min_px; kUnknown16 if neither the pixel nor one in the eight
    // directions from it matched.
    std::vector<std::int16_t> disparities;
    std::vector<std::uint8_t> is_matched;  // 1 = both views agree, 0 = filled
};

// Returns the disparities of the left view. Pixels on which the views disagree are filled: from the match of
// the pair at half size if that is certain, else from the pixels around them. Both images must have one size;
// if their numbers of channels differ, both are converted to grey. Ranges of more than 64 disparities are
// matched coarse to fine (see sgm/window_step.h). Memory for the costs: 32 MiB, or some 2 sqrt(height) rows
// at 192 bytes per pixel if that is more.
MatchedMap match_pair(const StereoPair& pair, const MatchingConfig& config, int threads);

// Returns only the disparities that both views agree on, before filling and smoothing;
// all others are unknown.
MatchedMap match_trusted(const StereoPair& pair, const MatchingConfig& config, int threads);

// Does only the second half of match_pair(), for both views' disparities (in 1/16 px above min_px, kUnknown16
// = unknown) from another matcher.
MatchedMap refine_views(const StereoPair& pair, const ViewDisparities& views, const MatchingConfig& config,
                        int threads);

// Continues surfaces beyond the right picture's left edge, where nothing matches and match_pair() leaves
// about the disparity of the edge. In each row the surface goes on with its slope right of the edge, as far
// there as the strip is wide, if both halves of that part slope alike: with the lesser slope; a slope that
// flattens towards the edge goes on flattening. min_px: the range's least disparity.
void continue_beyond_frame(MatchedMap& map, int min_px);

// Curves from the right picture's levels to the left picture's, because cameras may expose differently or see
// colours differently: curves[channel][level in the right picture] = level in the left one. One curve serves
// for all channels if the views' numbers of channels differ. Empty = the levels are the same.
using LightCurves = std::vector<std::array<std::uint8_t, 256>>;

// Finds the curves from the levels at matched points (`map` is this pair's, from min_px on). The levels of
// each view are sorted and divided into eighths; the mean of each eighth in the right view is mapped to that
// in the left one, with straight lines between them. Returns no curves if fewer than 256 points match.
LightCurves find_light(const StereoPair& pair, const MatchedMap& map, int min_px);

// Applies the curves to a picture of 1 or 3 channels.
void relight(Image& right, const LightCurves& curves, int threads);

// Returns the standard deviation of the picture's noise, in levels of a channel: that which a tenth of its
// blocks of 16x16 pixels fall short of (Immerkaer 1996). Blocks that are nearly black or white are ignored; 0
// if there are no others.
double find_noise(const Image& image);

// Reduces noise of 4 levels and more, which disturbs matching, by averaging over similar pixels of 5x5 (a
// bilateral filter). `noise` is the value from find_noise().
void denoise(Image& image, double noise, int threads);

}  // namespace hexrelief::matching
