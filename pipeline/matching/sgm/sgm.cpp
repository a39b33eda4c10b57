#include "pipeline/matching/sgm/sgm.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/sgm/window_step.h"

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

// Returns the number of rows of a block: as many as fit into block_bytes; or, if more, so many
// that a block takes as much memory as the costs kept between the blocks; or two per thread if
// these fit into kLargestVolume_bytes.
int block_rows(std::size_t row_entries, const Rows& band, std::size_t block_bytes, int threads) {
    const auto rows_in = [&](std::size_t bytes) {
        return static_cast<int>(
            std::min<std::size_t>(bytes / (kEntry_bytes * row_entries), std::size_t{1} << 30));
    };
    const int balanced = static_cast<int>(std::sqrt(2.0 / 3 * band.count()));
    const int busy = std::min(2 * threads, rows_in(kLargestVolume_bytes));
    return std::min(band.count(), std::max({rows_in(block_bytes), balanced, busy, 1}));
}

// Matches a band without ever holding its whole volume. On the way down only the vertical paths
// are followed, and their costs are kept above each block of rows; on the way up each block's
// volume is computed from these.
void match_band(const MatchingInput& input, const Band& matched, std::size_t block_bytes,
                ViewDisparities& views, ThreadPool& pool) {
    const int width = input.left.width(), run = run_length(input.range);
    const std::size_t row_entries = static_cast<std::size_t>(width) * 2 * run;
    const Rows &band = matched.rows, &kept = matched.kept;
    const int rows = block_rows(row_entries, band, block_bytes, pool.size());
    const int blocks = (band.count() + rows - 1) / rows;
    MatchingVolume volume(width, band.first, rows, run);
    PathRows above(blocks, row_entries), below(1, row_entries);
    const auto move_to = [&](int block) {
        volume.first_row = band.first + block * rows;
        volume.rows = std::min(rows, band.end - volume.first_row);
    };
    above.begin(0, band.first, input.penalties);
    for (int block = 0; block + 1 < blocks; ++block) {
        move_to(block);
        descend(input, above.row(block), above.row(block + 1), volume, pool);
    }
    below.begin(0, band.end - 1, input.penalties);
    for (int block = blocks - 1; block >= 0; --block) {
        move_to(block);
        aggregate(input, above.row(block), below.row(0), volume, pool);
        const int first = std::max(kept.first, volume.first_row);
        const int end = std::min(kept.end, volume.first_row + volume.rows);
        if (first < end) find_winners(input, volume, first, end, views, pool);
    }
}

}  // namespace

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

void find_winners(const MatchingInput& input, const MatchingVolume& volume, int first, int end,
                  ViewDisparities& views, ThreadPool& pool) {
    for_each_row(pool, end - first, [&](int row) {
        std::vector<std::uint32_t> right(static_cast<std::size_t>(volume.width) + input.range.count +
                                         kWholeRange);
        find_winners_of_row(input, volume, first + row, right, views);
    });
}

ViewDisparities match_views(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                            WindowView windows, const step::PathPenalties& penalties, ThreadPool& pool,
                            std::size_t block_bytes) {
    const int width = left.width(), height = left.height();
    ViewDisparities views{Disparities16(width, height, kUnknown16), Disparities16(width, height, kUnknown16)};
    for (const Band& band : bands_of(width, height))
        match_band({left, right, range, windows, penalties}, band, block_bytes, views, pool);
    return views;
}

int band_rows(int width, int height) {
    const std::size_t row_bytes = kEntry_bytes * static_cast<std::size_t>(width) * kWholeRange;
    // Even, because pairs of rows have the same windows.
    const auto rows =
        static_cast<int>(std::min<std::size_t>(kLargestVolume_bytes / row_bytes, 1u << 30)) / 2 * 2;
    return std::min(height, std::max(rows, 2 * kBandMargin + 16));
}

std::vector<Band> bands_of(int width, int height) {
    const int rows = band_rows(width, height);
    if (rows == height) return {{{0, height}, {0, height}}};
    const int kept = rows - 2 * kBandMargin;
    std::vector<Band> bands;
    for (int y = 0; y < height; y += kept) {
        const int end = std::min(height, y + kept);
        bands.push_back({{std::max(0, y - kBandMargin), std::min(height, end + kBandMargin)}, {y, end}});
    }
    return bands;
}

}  // namespace hexrelief::matching
