// Selects the trusted matches among both views' winners.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::matching {

struct ConsistencyConfig {
    int min_px = 0;            // least disparity of the range
    int left_right_limit = 9;  // 1/16 px: largest difference between the two views; < 0 = no check
    int speckle_pixels = 100;  // patches of at most this many pixels are removed; 0 = off
    int speckle_step = 32;     // 1/16 px: a larger difference ends a patch
    int least = 0;             // 1/16 px above min_px: patches farther away than this have to be larger

    bool operator==(const ConsistencyConfig&) const = default;
};
// Returns the configuration for the pair at half its size, except min_px, which comes from that pair's range.
inline ConsistencyConfig at_half_size(ConsistencyConfig config) {
    config.least /= 2;
    return config;
}

struct TrustedMatches {
    Disparities16 left;   // unknown where the views disagree
    Disparities16 right;  // unknown where the views disagree
    // The largest disparity that the right camera certainly sees, at its own columns, in 1/16 px; kAnything
    // if it is not certain.
    Raster<std::int32_t> nearest_seen;
};

// Returns the median of each pixel and its eight neighbours, like step::median_around(): an unknown pixel
// becomes known if five or more neighbours are known.
Disparities16 median_filtered(const Disparities16& map, ThreadPool& pool);

// Returns the matches that both views' medians agree on, without speckles.
TrustedMatches find_trusted_matches(const ViewDisparities& views, const ConsistencyConfig& config,
                                    ThreadPool& pool);

}  // namespace hexrelief::matching
