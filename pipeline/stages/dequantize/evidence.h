// What both pictures tell of each pixel's disparity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Numbers of an image's pixels, row-major, top row first.
struct Plane {
    int width = 0, height = 0;
    std::vector<float> values;

    Plane(int columns, int rows)
        : width(columns), height(rows), values(static_cast<std::size_t>(columns) * rows) {}
    float* row(int y) { return &values[static_cast<std::size_t>(y) * width]; }
    const float* row(int y) const { return &values[static_cast<std::size_t>(y) * width]; }
};

struct Evidence {
    Plane target;     // the disparity at which the pictures agree, px; at most 1 px from the map's
    Plane certainty;  // 1 over its variance, 1/px^2; 0 where the map has no match in the right picture
    Plane around;     // the sum of certainties over 7x7 pixels
    float miss;       // what the pictures differ by where there is detail: a standard deviation, in levels
};

// The levels of a pair, less their means over 15x15 pixels: light differs.
class PairLevels {
  public:
    PairLevels(const StereoPair& pair, ThreadPool& pool);
    // Compares the left picture with the right one at the map's disparities. map: of the pair's size.
    Evidence evidence_for(const DisparityMap& map, ThreadPool& pool) const;

  private:
    Plane left_, right_, left_detail_;
};

// Returns the upper median of numbers >= 0; 0 if there are none.
float median_of(std::vector<float> values);

template <typename Body>
void for_rows(ThreadPool& pool, int height, const Body& body) {
    pool.parallel_for(static_cast<std::size_t>(height), [&](std::size_t first, std::size_t end) {
        for (std::size_t y = first; y < end; ++y) body(static_cast<int>(y));
    });
}

}  // namespace hexrelief::stages
