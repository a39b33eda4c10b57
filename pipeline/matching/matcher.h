// Manual of the matcher: from a rectified pair to disparities, by semi-global matching on census and colour
// (Hirschmueller 2008), filled and lined up with the left picture's colours. Callers need no other header of
// this folder. All arithmetic is in whole numbers, or in floats that hold whole numbers: the same bytes for
// any number of threads, and by cuda/matching.
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
    // left(x, y) = right(x - d, y) is tried for min_px <= d < min_px + count. count: 1..1920:
    // planes are followed beyond the range, and 16 bits have to hold that.
    DisparityRange range;
    // Of a step of 1 px and of more along a path: 1 <= p1 < p2 <= 16000.
    step::PathPenalties penalties;
    // Its min_px is the range's.
    ConsistencyConfig consistency;

    bool operator==(const MatchingConfig&) const = default;
};

// Row-major, top row first, width * height entries each.
struct MatchedMap {
    int width = 0, height = 0;
    // 1/16 px above range.min_px; kUnknown16 where nothing matched, neither there nor in eight directions.
    std::vector<std::int16_t> disparities;
    std::vector<std::uint8_t> is_matched;  // 1 = both views agree, 0 = filled
};

// Disparities of the left view. Pixels on which the views disagree are filled: from the match of the pair at
// half size, where that is sure, else from the pixels around them. Both images have one size; where their
// channels differ, both are taken as grey. Ranges of more than 64 disparities are matched coarse to fine (see
// sgm/window_step.h). Memory for the costs: 32 MiB, or what some 2 sqrt(height) rows take at 192 bytes a
// pixel.
MatchedMap match_pair(const StereoPair& pair, const MatchingConfig& config, int threads);

// What both views agree on, before anything is filled or smoothed: the rest is unknown.
MatchedMap match_trusted(const StereoPair& pair, const MatchingConfig& config, int threads);

// The second half of match_pair() alone, for disparities of both views (1/16 px above min_px, kUnknown16
// where unknown) that another matcher found.
MatchedMap refine_views(const StereoPair& pair, const ViewDisparities& views, const MatchingConfig& config,
                        int threads);

// Cameras may expose differently, or see colours differently. Of each channel, or of all together where the
// views' channels differ, the level that the left picture has where the right one has this one. Empty: the
// same.
using LightCurves = std::vector<std::array<std::uint8_t, 256>>;

// By what both views show of the points that match (map: of this pair, from min_px on): the means of eighths
// of their levels, darkest to lightest, are those of each other, straight lines between. Empty where fewer
// than 256 points match.
LightCurves find_light(const StereoPair& pair, const MatchedMap& map, int min_px);

// The picture, 1 or 3 channels, as the curves say.
void relight(Image& right, const LightCurves& curves, int threads);

// The standard deviation of the picture's noise, in levels of a channel: that of the smoothest tenth of its
// blocks of 16x16 pixels (Immerkaer 1996). 0 where there is none that is neither white nor black.
double find_noise(const Image& image);

// Noise that disturbs matching, of 4 levels and more, is averaged out over pixels alike of 5x5 (a bilateral
// filter). noise: as find_noise() says.
void denoise(Image& image, double noise, int threads);

}  // namespace hexrelief::matching
