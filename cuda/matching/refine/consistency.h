// From both views' winners to matches that can be trusted.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/common/pixel_list.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief::cuda {

struct Median {
    matching::DisparityView map;  // with a border of kUnknown16
    matching::DisparityOut out;   // <- the median of each pixel and its neighbours
};
void filter_median(cudaStream_t stream, const Median& median);
// Of maps of one size, in one launch.
void filter_medians(cudaStream_t stream, const Median& first, const Median& second);

// checked <- left where step::checked_match() finds nothing against it.
void check_left(cudaStream_t stream, const matching::DisparityView& left,
                const matching::DisparityView& right, const matching::ConsistencyConfig& config,
                const matching::DisparityOut& checked);

struct TrustedRasters {
    matching::DisparityOut right;                     // of the right view, with a border of kUnknown16
    matching::RasterView<std::int32_t> nearest_seen;  // without a border
    matching::RasterView<std::uint8_t> matched;       // without a border; 1 where `checked` is known
    PixelList holes;                                  // the other pixels; empty before
};
// Sets unknown pixels of checked from trusted matches at half size (see half_size_match() of
// pipeline/matching/refine). right: of TrustedRasters. half: with a border of kUnknown16.
void add_half_size_matches(cudaStream_t stream, const matching::DisparityView& half, int half_min_px,
                           const matching::DisparityView& right, int min_px,
                           const matching::DisparityOut& checked);
// checked: the left view without speckles.
void find_trusted(cudaStream_t stream, const matching::DisparityView& checked,
                  const matching::DisparityView& right, const matching::ConsistencyConfig& config,
                  const TrustedRasters& out);

}  // namespace hexrelief::cuda
