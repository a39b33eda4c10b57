#include "pipeline/stages/view_check.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace hexrelief {

void check_left_right(RawDisparities& left, const RawDisparities& right, double limit_px) {
    const int limit = static_cast<int>(std::floor(std::min(limit_px, 2048.0) * kRawScale));
    for (int y = 0; y < left.height; ++y) {
        std::int16_t* const row = left.values.data() + static_cast<std::size_t>(y) * left.width;
        const std::int16_t* const other = right.values.data() + static_cast<std::size_t>(y) * left.width;
        for (int x = 0; x < left.width; ++x) {
            const int d = row[x];
            if (d == kUnmatched) continue;
            const auto agrees = [&](int match) {
                return match >= 0 && match < left.width && other[match] != kUnmatched &&
                       std::abs(other[match] - d) <= limit;
            };
            const int floor_d = d >= 0 ? d / kRawScale : -((-d + kRawScale - 1) / kRawScale);
            const int ceil_d = floor_d + (d != floor_d * kRawScale);
            if (!agrees(x - floor_d) && !agrees(x - ceil_d)) row[x] = kUnmatched;
        }
    }
}

void fill_unknown(DisparityMap& map) {
    const auto row_at = [&](int y) {
        return map.values.begin() + static_cast<std::ptrdiff_t>(y) * map.width;
    };
    std::vector<int> known_rows;
    for (int y = 0; y < map.height; ++y) {
        const auto row = row_at(y);
        int from = 0;
        float before = kUnknownDisparity;
        for (int x = 0; x <= map.width; ++x) {
            if (x < map.width && !DisparityMap::known(row[x])) continue;
            const float after = x < map.width ? row[x] : kUnknownDisparity;
            std::fill(row + from, row + x, std::min(before, after));
            before = after;
            from = x + 1;
        }
        if (map.width > 0 && DisparityMap::known(row[0])) known_rows.push_back(y);
    }
    if (known_rows.empty()) return;
    for (int y = 0; y < map.height; ++y) {
        if (map.width == 0 || DisparityMap::known(row_at(y)[0])) continue;
        const auto after = std::lower_bound(known_rows.begin(), known_rows.end(), y);
        int source = after == known_rows.end() ? known_rows.back() : *after;
        if (after != known_rows.begin() && y - *(after - 1) <= std::abs(source - y)) source = *(after - 1);
        std::copy(row_at(source), row_at(source) + map.width, row_at(y));
    }
}

}  // namespace hexrelief
