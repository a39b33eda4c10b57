// Smooths away the lumps that matching leaves on surfaces.
#pragma once

#include "cuda/matching/refine/pixel_record.h"

namespace hexrelief::cuda {

// Smooths at all levels. The two record rasters, with borders, are written in turn; result has no border.
void smooth(cudaStream_t stream, const matching::RasterView<PlaneRecord>& records,
            const matching::RasterView<PlaneRecord>& others, const matching::DisparityOut& result);

}  // namespace hexrelief::cuda
