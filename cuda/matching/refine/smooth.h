// Surfaces without the lumps that matching leaves.
#pragma once

#include "cuda/matching/refine/pixel_record.h"

namespace hexrelief::cuda {

// All levels: records, with borders, are written in turns; result has none.
void smooth(cudaStream_t stream, const matching::RasterView<PlaneRecord>& records,
            const matching::RasterView<PlaneRecord>& others, const matching::DisparityOut& result);

}  // namespace hexrelief::cuda
