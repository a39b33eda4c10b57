// Weighted medians that line discontinuities up with the picture's colours.
#pragma once

#include "cuda/matching/common/pixel_list.h"
#include "cuda/matching/refine/pixel_record.h"

namespace hexrelief::cuda {

struct VoteInput {
    matching::DisparityView map;                              // without unknown pixels
    PixelRecords records;                                     // of map, with their weights as voters
    matching::RasterView<const std::uint32_t> discontinuous;  // of SlopeArrays
    matching::RasterView<const std::int32_t> nearest_seen;
    matching::RasterView<const std::uint8_t> matched;  // the others are holes; origin null: none is
    PixelList holes;
    int min_px;
};
struct VoteArrays {
    PixelList near;                                     // pixels near discontinuities that are not holes
    matching::RasterView<std::uint8_t> changed_blocks;  // see RecordInput
};
VoteArrays take_vote_arrays(Arena& arena, int width, int height, const PixelList& near);

// voted <- the map with the weighted medians of pixels near discontinuities, and of holes. Sets arrays, whose
// list is empty before.
void take_votes(cudaStream_t stream, const VoteInput& input, const VoteArrays& arrays,
                const matching::DisparityOut& voted);

}  // namespace hexrelief::cuda
