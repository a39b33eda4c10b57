// Raises segments of the left picture beside its frame, which the host finds while the device matches.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/common/workspace.h"
#include "pipeline/matching/refine/frame_segments.h"

namespace hexrelief::cuda {

struct FrameArrays {
    int *cells, *firsts;  // see FrameSegments
    std::int16_t *samples, *least;
};
FrameArrays take_frame_arrays(Arena& arena, const matching::CellGrid& grid);

// Uploads the segments beside the device's other work and raises `filled` as least_disparities() says. known:
// bits of the pixels that were not filled, as in KnownPixels. All entries of arrays.least must be unknown.
void raise_frame_segments(Workspace& work, const matching::FrameSegments& segments, const FrameArrays& arrays,
                          const matching::RasterView<const std::uint32_t>& known,
                          const matching::DisparityOut& filled);

}  // namespace hexrelief::cuda
