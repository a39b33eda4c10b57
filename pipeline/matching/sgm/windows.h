// Which disparities of each pixel are searched.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching {

// From the left view's winners at half size (see step::find_window()); the whole window where the range
// is searched wholly, without reading half.
SearchWindows find_windows(int width, int height, const DisparityRange& range, DisparityView half,
                           ThreadPool& pool);

}  // namespace hexrelief::matching
