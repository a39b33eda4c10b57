#include "pipeline/matching/sgm/winners.h"

#include <algorithm>
#include <vector>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/sgm/window_step.h"
#include "pipeline/matching/sgm/winner_step.h"

namespace hexrelief::matching {
namespace {

// Returns the best key of a pixel's run, whose first disparity is `first` and of which `searched` entries are
// in the range. Also updates `right`, the best keys so far of the right pixels that match at each disparity.
HEXRELIEF_INLINED std::uint32_t best_of_run(const std::uint16_t* __restrict sums, int first, int searched,
                                            std::uint32_t* __restrict right) {
    std::uint32_t best = step::kNoWinner;
    for (int d = 0; d < searched; ++d) {
        const std::uint32_t key = step::winner_key(sums[d], static_cast<std::uint32_t>(first + d));
        best = best < key ? best : key;
        right[d] = right[d] < key ? right[d] : key;
    }
    return best;
}
HEXRELIEF_SMALL_VECTORS std::uint32_t best_of_pixel(const std::uint16_t* sums, SearchWindow window,
                                                    const DisparityRange& range, std::uint32_t* right) {
    const int run = run_length(range);
    const auto searched = [&](int first) { return std::clamp(range.count - first, 0, run); };
    const int far_run = window.far_run, near_run = window.near_run;
    const std::uint32_t far = best_of_run(sums, far_run, searched(far_run), right + far_run);
    const std::uint32_t near = best_of_run(sums + run, near_run, searched(near_run), right + near_run);
    return std::min(far, near);
}

void find_winners_of_row(const MatchingInput& input, const MatchingVolume& volume, int y,
                         std::vector<std::uint32_t>& right, ViewDisparities& views) {
    const DisparityRange& range = input.range;
    const int width = volume.width, count = range.count, min_px = range.min_px;
    const DisparityOut left_view = views.left.view(), right_view = views.right.view();
    const SearchWindow* windows = input.windows.row(y);
    // Refines the winner `key` of pixel x. The costs at the disparities beside it are those of the
    // pixels `before` and `behind`.
    const auto refined = [&](std::uint32_t key, int before, int behind) {
        const int d = step::winner_disparity(key);
        const int lower = step::entry_of(windows[before], d - 1, range),
                  upper = step::entry_of(windows[behind], d + 1, range);
        return static_cast<std::int16_t>(lower >= 0 && upper >= 0
                                             ? step::refined_winner(d, volume.sums_at(before, y)[lower],
                                                                    step::winner_sum(key),
                                                                    volume.sums_at(behind, y)[upper])
                                             : kOnePixel * d);
    };
    std::fill(right.begin(), right.end(), step::kNoWinner);
    for (int x = 0; x < width; ++x) {
        const std::uint32_t best =
            best_of_pixel(volume.sums_at(x, y), windows[x], range, right.data() + (width - 1 - x));
        left_view.at(x, y) = refined(best, x, x);
    }
    // right[i] is the best key of the right picture's pixel at width - 1 - min_px - i.
    for (int i = 0; i < width + count; ++i) {
        const std::uint32_t best = right[static_cast<std::size_t>(i)];
        const int xr = width - 1 - min_px - i, x = width - 1 - i + step::winner_disparity(best);
        if (xr < 0 || xr >= width || best == step::kNoWinner) continue;
        right_view.at(xr, y) = x > 0 && x + 1 < width
                                   ? refined(best, x - 1, x + 1)
                                   : static_cast<std::int16_t>(kOnePixel * step::winner_disparity(best));
    }
}

}  // namespace

void find_winners(const MatchingInput& input, const MatchingVolume& volume, int first, int end,
                  ViewDisparities& views, ThreadPool& pool) {
    for_each_row(pool, end - first, [&](int row) {
        std::vector<std::uint32_t> right(static_cast<std::size_t>(volume.width) + input.range.count +
                                         kWholeRange);
        find_winners_of_row(input, volume, first + row, right, views);
    });
}

}  // namespace hexrelief::matching
