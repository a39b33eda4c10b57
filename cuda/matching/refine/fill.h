// Fills unknown pixels from the matches around them.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/common/pixel_list.h"
#include "cuda/matching/refine/slopes.h"
#include "pipeline/matching/refine/fill_step.h"

namespace hexrelief::cuda {

// The known pixels of a map, a bit each, along all lines through it. A falling line runs to the right and
// down, a rising one to the right and up.
struct KnownPixels {
    enum Kind { kColumns, kFalling, kRising, kKinds };

    int width, height;
    matching::RasterView<std::uint32_t> rows;  // indexed by word and row
    matching::RasterView<std::uint32_t>
        words[kKinds];  // indexed by line and word; a word holds 32 rows of the picture

    __host__ __device__ int lines(Kind kind) const { return kind == kColumns ? width : width + height - 1; }
    __host__ __device__ int line_of(Kind kind, int x, int y) const {
        return kind == kColumns ? x : kind == kFalling ? x - y + height - 1 : x + y;
    }
    __host__ __device__ int x_of(Kind kind, int line, int y) const {
        return kind == kColumns ? line : kind == kFalling ? line + y - (height - 1) : line - y;
    }
};
KnownPixels take_known_pixels(Arena& arena, int width, int height);

struct FillInput {
    PixelList holes;                // pixels without a match
    matching::DisparityView right;  // trusted matches of the right view
    PixelRecords records;           // records of the map
    matching::RasterView<const std::int32_t> nearest_seen;
    PackedColors left_colors, right_colors;
    int min_px;
};

// Sets the bits of `known` from the map.
void find_known(cudaStream_t stream, const matching::DisparityView& map, const KnownPixels& known);
// Fills the holes that are unknown in the map.
void fill_unknown(cudaStream_t stream, const FillInput& input, const KnownPixels& known,
                  const matching::DisparityOut& map);

}  // namespace hexrelief::cuda
