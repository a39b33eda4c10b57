// Selects trusted matches from both views' winners.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/common/pixel_list.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief::cuda {

struct Median {
    DisparityView map;  // with a border of kUnknown16
    DisparityOut out;   // receives the median of each pixel and its neighbours
};
void filter_median(cudaStream_t stream, const Median& median);
// Filters two maps of one size in one launch.
void filter_medians(cudaStream_t stream, const Median& first, const Median& second);

// Sets `checked` to the left view's matches to which step::checked_match() has no objection.
void check_left(cudaStream_t stream, const DisparityView& left, const DisparityView& right,
                const ConsistencyConfig& config, const DisparityOut& checked);

struct TrustedRasters {
    DisparityOut right;                     // trusted matches of the right view, with a border of kUnknown16
    RasterView<std::int32_t> nearest_seen;  // without a border
    RasterView<std::uint8_t> matched;       // without a border; 1 where `checked` is known
    PixelList holes;                        // the other pixels; must be empty before
};
// Fills unknown pixels of `checked` with trusted matches at half size (see half_size_match() of
// pipeline/matching/refine). right: that of TrustedRasters; half: with a border of kUnknown16.
void add_half_size_matches(cudaStream_t stream, const DisparityView& half, int half_min_px,
                           const DisparityView& right, int min_px, const DisparityOut& checked);
// Finds the trusted rasters. checked: the left view without speckles.
void find_trusted(cudaStream_t stream, const DisparityView& checked, const DisparityView& right,
                  const ConsistencyConfig& config, const TrustedRasters& out);

}  // namespace hexrelief::cuda
