#include "pipeline/matching/sgm/sgm.h"

#include <algorithm>
#include <cmath>

#include "pipeline/matching/sgm/bands.h"
#include "pipeline/matching/sgm/paths.h"

namespace hexrelief::matching {
namespace {

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

ViewDisparities match_views(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                            WindowView windows, const step::PathPenalties& penalties, ThreadPool& pool,
                            std::size_t block_bytes) {
    const int width = left.width(), height = left.height();
    ViewDisparities views{Disparities16(width, height, kUnknown16), Disparities16(width, height, kUnknown16)};
    for (const Band& band : bands_of(width, height))
        match_band({left, right, range, windows, penalties}, band, block_bytes, views, pool);
    return views;
}

}  // namespace hexrelief::matching
