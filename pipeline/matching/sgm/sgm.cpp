#include "pipeline/matching/sgm/sgm.h"

#include <algorithm>

#include "pipeline/matching/sgm/paths.h"

namespace hexrelief {

int band_rows(int width, int height, int count) {
    constexpr std::size_t kEntry_bytes = sizeof(std::uint8_t) + sizeof(std::uint16_t);
    const std::size_t row_bytes = kEntry_bytes * static_cast<std::size_t>(width) * count;
    const auto rows = static_cast<int>(std::min<std::size_t>(kLargestVolume_bytes / row_bytes, 1u << 30));
    return std::min(height, std::max(rows, 2 * kBandMargin + 16));
}

ViewDisparities match_views(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                            const step::PathPenalties& penalties, ThreadPool& pool) {
    const int width = left.width(), height = left.height();
    ViewDisparities views{Disparities16(width, height, kUnknown16), Disparities16(width, height, kUnknown16)};
    const int rows = band_rows(width, height, range.count);
    const int kept = rows == height ? height : rows - 2 * kBandMargin;
    for (int y = 0; y < height; y += kept) {
        const int end = std::min(height, y + kept);
        const int first = rows == height ? 0 : std::max(0, y - kBandMargin);
        const int last = rows == height ? height : std::min(height, end + kBandMargin);
        MatchingVolume volume(width, first, last - first, range.count);
        aggregate(left, right, range, penalties, volume, pool);
        find_winners(volume, range.min_px, y, end, views, pool);
    }
    return views;
}

}  // namespace hexrelief
