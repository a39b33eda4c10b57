// Which disparities of each pixel are searched.
#pragma once

#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

// half: the left view's winners at half size (see step::find_window()); not read where kSearched disparities
// are all that there are.
void find_windows(cudaStream_t stream, const RasterView<std::int16_t>& half, const DisparityRange& range,
                  const RasterView<SearchWindow>& windows);

}  // namespace hexrelief::cuda
