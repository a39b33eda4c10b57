// The parts of evaluate_disparity(). All maps have one size.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::evaluation {

inline bool is_given(float d) {
    return DisparityMap::known(d) && d != 0;
}

// Returns for each pixel 1 if the truth is known and the right view sees the pixel as well, else 0: by the
// right view's truth, or, if that is null, by the left view's truth.
std::vector<std::uint8_t> find_nonoccluded(const DisparityMap& truth, const DisparityMap* right_truth);

struct EdgeCounts {
    long long pixels = 0, wrong = 0, unknown = 0;
};
EdgeCounts count_edges(const DisparityMap& map, const DisparityMap& truth, float discontinuity_px);

struct Roughness {
    double rms_px = 0;
    long long windows = 0;
};
// Measures the roughness on windows that start at every step_px-th column and row.
Roughness measure_roughness(const DisparityMap& map, const DisparityMap& truth, int step_px);

}  // namespace hexrelief::evaluation
