// Chooses the disparities that are searched at each pixel.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching {

// Returns the windows, from the left view's winners at half size (see step::find_window()). If the range is
// searched completely, all windows are kWholeWindow and `half` is not read.
SearchWindows find_windows(int width, int height, const DisparityRange& range, DisparityView half,
                           ThreadPool& pool);

}  // namespace hexrelief::matching
