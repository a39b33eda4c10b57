// The known pixels of a sparse map, and the nearest of them at each pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// A plane through a pixel: disparity d + slope_x * dx + slope_y * dy px at (dx, dy) px from (x, y).
struct PlaneAt {
    int x = 0, y = 0;
    float d = 0, slope_x = 0, slope_y = 0;

    float at(int px, int py) const {
        return d + slope_x * static_cast<float>(px - x) + slope_y * static_cast<float>(py - y);
    }
};

// Returns the known pixels in row-major order, as planes that face the camera.
std::vector<PlaneAt> measurements_of(const DisparityMap& map);

inline constexpr std::uint32_t kNoMeasurement = 0xffffffffu;

struct NearestMeasurements {
    int width, height;
    // Index of each pixel's nearest measurement; kNoMeasurement if there is none.
    std::vector<std::uint32_t> index;
    std::vector<std::uint32_t> distance;  // in 1/16 px

    // Returns the nearest measurement's index; kNoMeasurement outside the picture.
    std::uint32_t of(int x, int y) const {
        if (x < 0 || x >= width || y < 0 || y >= height) return kNoMeasurement;
        return index[static_cast<std::size_t>(y) * width + x];
    }
};
inline constexpr std::uint32_t kDistanceOne = 16;  // 1 px

// Finds the measurement with the shortest path to each pixel (chamfer distances); each colour step of 1 along
// the path adds 1 px. `left` may be empty. Made of two sweeps over the picture and back, so that a path that
// turns often may be missed.
NearestMeasurements find_nearest(const std::vector<PlaneAt>& measurements, int width, int height,
                                 const Image& left);

// Returns the largest difference of a channel.
inline int color_step(const std::uint8_t* a, const std::uint8_t* b, int channels) {
    int largest = 0;
    for (int c = 0; c < channels; ++c) {
        const int step = a[c] > b[c] ? a[c] - b[c] : b[c] - a[c];
        largest = step > largest ? step : largest;
    }
    return largest;
}

}  // namespace hexrelief::stages
