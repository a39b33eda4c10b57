// The slopes of the surfaces of a disparity map.
#pragma once

#include "cuda/matching/refine/pixel_record.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief::cuda {

// A pixel's disparity and the slopes of the lines through it, as fit_slopes() packs them; 0 = unknown.
struct alignas(8) FittedPixel {
    std::uint32_t slopes;
    std::int32_t disparity;
};
struct SlopeArrays {
    matching::RasterView<FittedPixel> fitted;  // with a border of zeros
    // A bit for each of 32 pixels of a row; origin null: not wanted.
    matching::RasterView<std::uint32_t> discontinuous;
};

// The pixels whose records are wanted: all, or the known ones beside unknown ones, from
// which these are filled.
enum class RecordsOf { all, beside_unknown };

struct RecordInput {
    matching::DisparityView map;
    PackedColors colors;
    matching::RasterView<const std::uint8_t>
        voter_weights;         // set in the first round; else its origin is null
    PackedColors hole_colors;  // read only in the first round
    RecordsOf which;
    int slope_stride_px;  // see slope_step.h; kNearSlopes_px if changed_blocks is set
    // One byte per block of pixel_blocks(): nonzero if it may differ from the map for which arrays and
    // records were made; origin null: all may differ.
    matching::RasterView<const std::uint8_t> changed_blocks;
};

// Sets records to the map with its slopes, and arrays to the fitted lines and the pixels with a
// step::discontinuous() neighbour. Leaves borders as they are.
template <typename Record>  // PixelRecord or PlaneRecord
void find_slopes(cudaStream_t stream, const RecordInput& input, const SlopeArrays& arrays,
                 const matching::RasterView<Record>& records);

}  // namespace hexrelief::cuda
