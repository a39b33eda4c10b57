// Disparities in pixels, and the rectified pair that they come from.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief {

inline constexpr float kUnknownDisparity = std::numeric_limits<float>::infinity();

// Where a pixel's disparity comes from: found in both views of a pair, or filled from pixels that were.
enum class PixelOrigin : std::uint8_t { unknown, matched, filled };

// Row-major, top row first, true pixels: left(x, y) = right(x - d, y). Unknown is +infinity, never NaN.
struct DisparityMap {
    int width = 0;
    int height = 0;
    std::vector<float> values;              // width * height
    std::vector<PixelOrigin> origins = {};  // likewise, of a matched map; empty for one that was read

    float at(int x, int y) const { return values[static_cast<std::size_t>(y) * width + x]; }
    float& at(int x, int y) { return values[static_cast<std::size_t>(y) * width + x]; }
    static bool known(float d) { return std::isfinite(d); }
};

// Of a picture that can be rectified and matched: OpenCV counts the pixels of a side with 15 bits.
inline constexpr int kLargestPairSide_px = 32766;

// Rectified: the same scene row lies on the same image row. Both images have one size.
struct StereoPair {
    Image left;
    Image right;
};

}  // namespace hexrelief
