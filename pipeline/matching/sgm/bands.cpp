#include "pipeline/matching/sgm/bands.h"

#include <algorithm>

#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching {

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
