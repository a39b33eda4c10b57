// Weighted medians that line discontinuities up with the picture's colours.
#pragma once

#include "cuda/matching/refine/pixel_record.h"

namespace hexrelief::cuda {

struct VoteInput {
    DisparityView map;     // without unknown pixels
    PixelRecords records;  // of map, with their weights as voters
    RasterView<const std::int32_t> nearest_seen;
    RasterView<const std::uint8_t> matched;  // the others are holes; origin null: none is
    int min_px;
};
struct VoteArrays {
    RasterView<std::uint32_t> discontinuous;  // a bit for each of 32 pixels of a row
    std::uint32_t* list;                      // an entry a pixel
    std::uint32_t* counts;                    // two
};

// voted <- the map with the weighted medians of pixels near discontinuities, and of those not matched.
void take_votes(cudaStream_t stream, const VoteInput& input, const VoteArrays& arrays,
                const DisparityOut& voted);

}  // namespace hexrelief::cuda
