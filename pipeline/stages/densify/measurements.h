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

// Returns the 90th percentile, in px, of the distance to the nearest measurement, over unknown pixels that
// have measurements on both sides in their row or column. Distances of more than four times the median are
// ignored, because such pixels lie in a hole. At least 1.
int typical_distance_px(const DisparityMap& map, const NearestMeasurements& nearest);

// Returns 1 for the pixels that measurements surround or are near to, else 0: gaps of up to six typical
// distances and 8 px are closed, and the outermost measurements are extended by a typical distance and 2 px,
// or by half a gap at the picture's edges. nearest: without colours.
std::vector<std::uint8_t> pixels_to_fill(const DisparityMap& map, const NearestMeasurements& nearest,
                                         int typical_px);

struct Sparsity {
    double known_share = 0;  // share of all pixels
    // Share of the known pixels' neighbours along rows, and along columns, that are known as well.
    double joined_along_rows = 0, joined_along_columns = 0;

    // True if unknown pixels lie between the known ones: along rows or along columns most known pixels have
    // an unknown neighbour. In a map of surfaces nearly all neighbours of known pixels are known, however
    // large its holes are.
    bool is_sparse() const;
};

Sparsity measure_sparsity(const DisparityMap& map);

}  // namespace hexrelief::stages
