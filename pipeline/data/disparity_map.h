// Disparity maps in pixels, and the rectified pairs that they come from.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief {

inline constexpr float kUnknownDisparity = std::numeric_limits<float>::infinity();

// The origin of a pixel's disparity: matched in both views of a pair, or filled from such pixels around it.
enum class PixelOrigin : std::uint8_t { unknown, matched, filled };

// Row-major, top row first; in pixels of this map: left(x, y) = right(x - d, y). Unknown
// is +infinity, never NaN.
struct DisparityMap {
    int width = 0;
    int height = 0;
    std::vector<float> values;              // width * height if the map was matched, else empty
    std::vector<PixelOrigin> origins = {};  // width * height if the map was matched, empty if it was read

    float at(int x, int y) const { return values[static_cast<std::size_t>(y) * width + x]; }
    float& at(int x, int y) { return values[static_cast<std::size_t>(y) * width + x]; }
    static bool known(float d) { return std::isfinite(d); }
};

// The least and the largest known disparity of maps, px.
struct KnownRange {
    float least = kUnknownDisparity, largest = -kUnknownDisparity;

    bool is_empty() const { return least > largest; }
    void add(const DisparityMap& map) {
        for (const float d : map.values) {
            if (!DisparityMap::known(d)) continue;
            least = std::min(least, d);
            largest = std::max(largest, d);
        }
    }
};
inline KnownRange known_range(const DisparityMap& map) {
    KnownRange range;
    range.add(map);
    return range;
}

// Returns the known disparities among every so many pixels.
inline std::vector<float> known_values(const DisparityMap& map, std::size_t every = 1) {
    std::vector<float> known;
    for (std::size_t i = 0; i < map.values.size(); i += every)
        if (DisparityMap::known(map.values[i])) known.push_back(map.values[i]);
    return known;
}

// Returns the value at this rank in ascending order, 0 = the least; reorders. rank < size
template <typename Values>
auto value_at_rank(Values& values, std::size_t rank) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
    std::ranges::nth_element(values, at);
    return *at;
}

// The largest width or height of a pair that can be rectified and matched: OpenCV counts the pixels of a
// side with 15 bits.
inline constexpr int kLargestPairSide_px = 32766;

// A rectified pair: a point of the scene lies on the same row of both images. Both have one size.
struct StereoPair {
    Image left;
    Image right;
};

}  // namespace hexrelief
