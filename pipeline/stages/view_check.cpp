#include "pipeline/stages/view_check.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace hexrelief::stages {

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

void remove_speckles(RawDisparities& map, int window_px, int range_px) {
    if (window_px <= 0) return;
    cv::Mat view(map.height, map.width, CV_16SC1, map.values.data());
    cv::filterSpeckles(view, kUnmatched, window_px, range_px * kRawScale);
}

}  // namespace hexrelief::stages
