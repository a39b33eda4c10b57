// Selects trusted matches from both views' winners.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/common/pixel_list.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief::cuda {

struct Median {
    matching::DisparityView map;  // with a border of kUnknown16
    matching::DisparityOut out;   // receives the median of each pixel and its neighbours
};
void filter_median(cudaStream_t stream, const Median& median);
// Filters two maps of one size in one launch.
void filter_medians(cudaStream_t stream, const Median& first, const Median& second);

// Sets `checked` to the left view's matches to which step::checked_match() has no objection.
void check_left(cudaStream_t stream, const matching::DisparityView& left,
                const matching::DisparityView& right, const matching::ConsistencyConfig& config,
                const matching::DisparityOut& checked);

struct TrustedRasters {
    matching::DisparityOut right;  // trusted matches of the right view, with a border of kUnknown16
    matching::RasterView<std::int32_t> nearest_seen;  // without a border
    matching::RasterView<std::uint8_t> matched;       // without a border; 1 where `checked` is known
    PixelList holes;                                  // the other pixels; must be empty before
};
// Fills unknown pixels of `checked` with trusted matches at half size (see half_size_match() of
// pipeline/matching/refine). right: that of TrustedRasters; half: with a border of kUnknown16.
void add_half_size_matches(cudaStream_t stream, const matching::DisparityView& half, int half_min_px,
                           const matching::DisparityView& right, int min_px,
                           const matching::DisparityOut& checked);
// Finds the trusted rasters. checked: the left view without speckles.
void find_trusted(cudaStream_t stream, const matching::DisparityView& checked,
                  const matching::DisparityView& right, const matching::ConsistencyConfig& config,
                  const TrustedRasters& out);

}  // namespace hexrelief::cuda
