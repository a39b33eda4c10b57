// What both pictures tell of each pixel's disparity.
#pragma once

#include <algorithm>
#include <bit>
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

// Returns the upper median of those of value(i), i < count, that are not negative; 0 if none is.
template <typename Value>
float median_of(std::size_t count, ThreadPool& pool, const Value& value) {
    // The bits of numbers that are not negative are in their order. Most of the values, far from the middle,
    // are sorted by their upper half alone.
    const auto upper = [](float v) { return std::bit_cast<std::uint32_t>(v) >> 16; };
    struct Own {
        std::vector<std::uint32_t> counts = std::vector<std::uint32_t>(std::size_t{1} << 15);
        std::vector<float> middle;
    };
    std::vector<Own> own(static_cast<std::size_t>(pool.size()));
    const auto for_values = [&](const auto& take) {
        pool.run([&](int thread) {
            for (std::size_t i = pool.share(count, thread); i < pool.share(count, thread + 1); ++i)
                if (const float v = value(i); v >= 0) take(own[static_cast<std::size_t>(thread)], v);
        });
    };
    for_values([&](Own& of, float v) { ++of.counts[upper(v)]; });
    const auto counted = [&](std::size_t at) {
        std::size_t sum = 0;
        for (const Own& of : own) sum += of.counts[at];
        return sum;
    };
    std::size_t all = 0, at = 0;
    for (std::size_t i = 0; i < own[0].counts.size(); ++i) all += counted(i);
    if (all == 0) return 0;
    std::size_t rank = all / 2;
    while (rank >= counted(at)) rank -= counted(at++);
    for_values([&](Own& of, float v) {
        if (upper(v) == at) of.middle.push_back(v);
    });
    std::vector<float> values;
    for (const Own& of : own) values.insert(values.end(), of.middle.begin(), of.middle.end());
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

template <typename Body>
void for_rows(ThreadPool& pool, int height, const Body& body) {
    pool.parallel_for(static_cast<std::size_t>(height), [&](std::size_t first, std::size_t end) {
        for (std::size_t y = first; y < end; ++y) body(static_cast<int>(y));
    });
}

}  // namespace hexrelief::stages
