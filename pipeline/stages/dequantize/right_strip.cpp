#include "pipeline/stages/dequantize/right_strip.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace hexrelief::stages {
namespace {

constexpr int kLeastShare = 60;  // of the longer side: matched pixels that show another surface
constexpr float kStep_px = 1;

// The length of the run of matched pixels from column x on that are one surface; `most` if it is longer.
int matched_run(const DisparityMap& map, std::size_t row, int x, int most) {
    int end = x;
    while (end < map.width && end < x + most && map.origins[row + end] == PixelOrigin::matched &&
           (end == x || std::abs(map.values[row + end] - map.values[row + end - 1]) <= kStep_px))
        ++end;
    return end - x;
}

}  // namespace

DisparityMap continued_at_right_end(DisparityMap map, const std::vector<std::uint8_t>& is_seen) {
    if (map.origins.empty() || is_seen.empty()) return map;
    const int least = std::max(map.width, map.height) / kLeastShare;
    for (int y = 0; y < map.height; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * map.width;
        int last = map.width - 1;
        while (last >= 0 && !is_seen[row + last]) --last;
        float before = kUnknownDisparity;
        for (int x = 0; x < map.width; ++x) {
            float& here = map.values[row + x];
            if (!DisparityMap::known(here)) {
                before = kUnknownDisparity;
                continue;
            }
            const bool is_beyond =
                DisparityMap::known(before) && static_cast<float>(x) - before > static_cast<float>(last);
            if (is_beyond && std::abs(here - before) > kStep_px && matched_run(map, row, x, least) < least)
                here = before;
            else
                before = here;
        }
    }
    return map;
}

}  // namespace hexrelief::stages
