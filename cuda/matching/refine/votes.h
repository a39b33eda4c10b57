// Weighted medians that align discontinuities with the picture's colours.
#pragma once

#include "cuda/matching/common/pixel_list.h"
#include "cuda/matching/refine/pixel_record.h"

namespace hexrelief::cuda {

struct VoteInput {
    matching::DisparityView map;                              // without unknown pixels
    PixelRecords records;                                     // the map's, with the pixels' weights as voters
    matching::RasterView<const std::uint32_t> discontinuous;  // see SlopeArrays
    matching::RasterView<const std::int32_t> nearest_seen;
    // Of the first round; origin null: there are no holes.
    matching::RasterView<const std::uint8_t> weights;
    PixelList holes;  // the pixels that are step::is_hole() by their weights
    int min_px;
};
struct VoteArrays {
    PixelList near;                                     // pixels near discontinuities that are not holes
    matching::RasterView<std::uint8_t> changed_blocks;  // see RecordInput
};
VoteArrays take_vote_arrays(Arena& arena, int width, int height, const PixelList& near);

// Sets `voted` to the map with weighted medians for pixels near discontinuities and for holes. Sets arrays,
// whose list must be empty before.
void take_votes(cudaStream_t stream, const VoteInput& input, const VoteArrays& arrays,
                const matching::DisparityOut& voted);

}  // namespace hexrelief::cuda
