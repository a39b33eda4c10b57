#include "pipeline/matching/sgm/windows.h"

#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/common/half_size_step.h"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief::matching {

SearchWindows find_windows(int width, int height, const DisparityRange& range, DisparityView half,
                           ThreadPool& pool) {
    SearchWindows windows(width, height, kWholeWindow);
    if (is_searched_wholly(range)) return windows;
    const int half_min_px = at_half_size(range).min_px;
    for_each_row(pool, half.height, [&](int y) {
        const RasterView<SearchWindow> out = windows.view();
        const int last_y = step::second_covered(y, height);
        for (int x = 0; x < half.width; ++x) {
            const SearchWindow window = step::find_window(half, half_min_px, range, x, y);
            const int last_x = step::second_covered(x, width);
            for (const int row : {step::first_covered(y), last_y})
                out.at(step::first_covered(x), row) = out.at(last_x, row) = window;
        }
    });
    return windows;
}

}  // namespace hexrelief::matching
