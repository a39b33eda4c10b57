// Segments of the left picture beside its frame, which the host finds.
#pragma once

#include "cuda/common/staging.h"
#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/refine/frame_segments.h"

namespace hexrelief::cuda {

struct FrameInput {
    const FrameEdges& edges;  // of the left picture
    DisparityView matches;    // what was filled from
    int min_px;
};

// filled <- raised as least_disparities() says. cells: as many as the picture's grid has, of any content.
// Waits for the stream.
void raise_frame_segments(cudaStream_t stream, Staging& staging, const FrameInput& input, std::int16_t* cells,
                          const DisparityOut& filled);

}  // namespace hexrelief::cuda
