// The inclination of the surfaces of a disparity map.
#pragma once

#include "cuda/matching/refine/pixel_record.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief::cuda {

// Slopes fitted along both axes, with a border; see find_slopes().
using FittedSlopes = RasterView<std::uint32_t>;

// Which pixels' records are found: all, or the known ones beside unknown ones, from which those are filled.
enum class RecordsOf { all, beside_unknown };

struct RecordInput {
    DisparityView map;
    PackedColors colors;
    RasterView<const std::uint8_t> voter_weights;  // of the first round; else its origin is null
    RecordsOf which;
};

// records <- the map with its slopes, by way of fitted. Leaves the border as it is.
void find_slopes(cudaStream_t stream, const RecordInput& input, const FittedSlopes& fitted,
                 const RasterView<PixelRecord>& records);

}  // namespace hexrelief::cuda
