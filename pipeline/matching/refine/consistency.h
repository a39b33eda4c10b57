// From both views' winners to matches that can be trusted.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::matching {

struct ConsistencyConfig {
    int min_px = 0;            // of the range
    int left_right_limit = 9;  // 1/16 px: largest difference of the two views; < 0 = no check
    int speckle_pixels = 100;  // patches up to this size are no matches; 0 = off
    int speckle_step = 32;     // 1/16 px: a larger difference ends a patch
    int least = 0;             // 1/16 px above min_px: what is farther has to be in larger patches

    bool operator==(const ConsistencyConfig&) const = default;
};
// Of the pair at half its size; its min_px is that range's.
inline ConsistencyConfig at_half_size(ConsistencyConfig config) {
    config.least /= 2;
    return config;
}

struct TrustedMatches {
    Disparities16 left;                 // unknown where the views disagree
    Disparities16 right;                // likewise
    Raster<std::int32_t> nearest_seen;  // by the right camera at its columns, 1/16 px; kAnything where unsure
};

// The median of each pixel and its neighbours; unknown pixels stay unknown.
Disparities16 median_filtered(const Disparities16& map, ThreadPool& pool);

// Of the views' medians.
TrustedMatches find_trusted_matches(const ViewDisparities& views, const ConsistencyConfig& config,
                                    ThreadPool& pool);

}  // namespace hexrelief::matching
