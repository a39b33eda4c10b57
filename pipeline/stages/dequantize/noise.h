// Measures the noise of a matched map, and decides how it is smoothed.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/dequantize/dequantize.h"

namespace hexrelief::stages {

// Bounds of the step. Finer steps are not visible in any mesh; larger ones are depth discontinuities
// to the surface stage.
inline constexpr double kLeastQuantum_px = 0.1, kLargestQuantum_px = 1;

// Returns the largest step in px of which all known disparities that were not filled (PixelOrigin) are
// multiples, apart from a common offset. Returns 0 if it is outside the bounds, as it is for maps of floats,
// and if all disparities are equal.
double find_quantum_px(const DisparityMap& map);

// Maps with less noise are left as they are: their surfaces are smooth, and what is not smooth is detail. A
// relief is a map of which it is not known where infinity lies: its depths are a guess, and its noise shows
// before its detail does.
inline constexpr double kLeastNoise_px = 0.07, kLeastNoiseOfRelief_px = 0.03;

// Returns the standard deviation of the noise of a matched map's disparities, px, by the median third
// difference of matches at the distances at which a mesh has its vertices. Third differences vanish on planes
// and on evenly curved surfaces, and the median ignores discontinuities. 0 if hardly anything is matched.
double find_noise_px(const DisparityMap& map, int threads);

// The argument of dequantize() that lets nearly all of a map's noise be smoothed, if there is at least
// `least_px`.
struct NoiseSmoothing {
    double noise_px = 0;    // 0 = nothing is to be smoothed
    double quantum_px = 0;  // a step of as much noise
};
NoiseSmoothing smoothing_for(double noise_px, double least_px = kLeastNoise_px);

// What both pictures tell of each pixel's disparity.

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
    const auto upper = [](float v) { return std::bit_cast<std::uint32_t>(std::abs(v)) >> 16; };
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
    return value_at_rank(values, rank);
}

}  // namespace hexrelief::stages
