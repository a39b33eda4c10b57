#include "pipeline/matching/sgm/windows.h"

#include "pipeline/matching/common/rows.h"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief {

SearchWindows find_windows(int width, int height, const DisparityRange& range, DisparityView half,
                           ThreadPool& pool) {
    SearchWindows windows(width, height, kWholeWindow);
    if (range.count <= kSearched) return windows;
    const int half_min_px = at_half_size(range).min_px;
    for_each_row(pool, height, [&](int y) {
        for (int x = 0; x < width; ++x)
            windows.view().at(x, y) = step::find_window(half, half_min_px, range, x, y);
    });
    return windows;
}

}  // namespace hexrelief
