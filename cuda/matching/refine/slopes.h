// The inclination of the surfaces of a disparity map.
#pragma once

#include "cuda/matching/refine/pixel_record.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief::cuda {

// With borders.
struct SlopeRasters {
    RasterView<std::int16_t> x, y;
};
struct RecordInput {
    DisparityView map;
    PackedColors colors;
    RasterView<const std::uint8_t> voter_weights;  // of the first round; else its origin is null
};

// records <- the map with its slopes, by way of fitted. Leaves the border as it is.
void find_slopes(cudaStream_t stream, const RecordInput& input, const SlopeReach& reach,
                 const SlopeRasters& fitted, const RasterView<PixelRecord>& records);

}  // namespace hexrelief::cuda
