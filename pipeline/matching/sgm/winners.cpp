#include "pipeline/matching/sgm/winners.h"

#include <algorithm>
#include <vector>

#include "mesher/common/simd.h"
#include "pipeline/matching/common/rows.h"
#include "pipeline/matching/sgm/winner_step.h"

namespace hexrelief {
namespace {

// right: the best yet of the pixels that match at each disparity. Returns the pixel's own best.
HEXRELIEF_SMALL_VECTORS std::uint32_t best_of_pixel(const std::uint16_t* __restrict sums, int count,
                                                    std::uint32_t* __restrict right) {
    std::uint32_t best = step::kNoWinner;
    for (int d = 0; d < count; ++d) {
        const std::uint32_t key = step::winner_key(sums[d], static_cast<std::uint32_t>(d));
        best = best < key ? best : key;
        right[d] = right[d] < key ? right[d] : key;
    }
    return best;
}

void find_winners_of_row(const MatchingVolume& volume, int min_px, int y, std::vector<std::uint32_t>& right,
                         ViewDisparities& views) {
    const int width = volume.width, last = volume.count - 1;
    const DisparityOut left_view = views.left.view(), right_view = views.right.view();
    std::fill(right.begin(), right.end(), step::kNoWinner);
    for (int x = 0; x < width; ++x) {
        const std::uint16_t* sums = volume.sums_at(x, y);
        const std::uint32_t best = best_of_pixel(sums, volume.count, right.data() + (width - 1 - x));
        const int d = step::winner_disparity(best);
        const bool inside = d > 0 && d < last;
        left_view.at(x, y) = static_cast<std::int16_t>(
            inside ? step::refined_winner(d, sums[d - 1], step::winner_sum(best), sums[d + 1])
                   : kOnePixel * d);
    }
    // right[i] is the best of the pixel that lies at width - 1 - min_px - i in the right picture.
    for (int i = 0; i < width + volume.count; ++i) {
        const int xr = width - 1 - min_px - i, d = step::winner_disparity(right[static_cast<std::size_t>(i)]);
        if (xr < 0 || xr >= width || right[static_cast<std::size_t>(i)] == step::kNoWinner) continue;
        const int x = width - 1 - i + d;
        const bool inside = d > 0 && d < last && x > 0 && x + 1 < width;
        right_view.at(xr, y) = static_cast<std::int16_t>(
            inside ? step::refined_winner(d, volume.sums_at(x - 1, y)[d - 1],
                                          step::winner_sum(right[static_cast<std::size_t>(i)]),
                                          volume.sums_at(x + 1, y)[d + 1])
                   : kOnePixel * d);
    }
}

}  // namespace

void find_winners(const MatchingVolume& volume, int min_px, int first, int end, ViewDisparities& views,
                  ThreadPool& pool) {
    for_each_row(pool, end - first, [&](int row) {
        std::vector<std::uint32_t> right(static_cast<std::size_t>(volume.width) + volume.count);
        find_winners_of_row(volume, min_px, first + row, right, views);
    });
}

}  // namespace hexrelief
