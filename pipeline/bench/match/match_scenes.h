// The pairs of `hexrelief bench match`: which of them a folder holds, and how they are made harder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::bench::match {

namespace fs = std::filesystem;

struct ScenePair {
    std::string name;  // its folder's, such as cones-quarter; with -color for a second pair in it
    std::string size;  // small, half or full: rows of one size are averaged together
    fs::path left, right, truth;
    fs::path right_truth;  // empty = none
    double scale = 1;      // raw value / scale = px
    double discontinuity_px = 1;
};

// Every folder below `data` that holds left.*, right.* and disp.*, in the order of their paths, where
// left_color.* and right_color.* are a pair of their own. Middlebury's scales: 16 for tsukuba, 8 for other
// scenes below middlebury2001, 1 for floats; otherwise 4, 3, 2, 1 for names that end in -quarter, -third,
// -half, -full. `left_out` gets a line for each folder whose scale is not known. Throws Error(input) where
// there is no such folder.
std::vector<ScenePair> find_scenes(const fs::path& data, std::vector<std::string>& left_out);

// Noise of the sensor and a light that differs. All are neutral by default.
struct Disturbance {
    double noise_percent = 0;    // standard deviation of every sample of both images, of 255; 0..100
    double gamma = 1, gain = 1;  // of the right view: 255 * gain * (v / 255)^gamma; above 0
};
// Throws Error(usage) where a number is out of its range.
void check_disturbance(const Disturbance& disturbance);
// Light first, then noise. The same bytes wherever it runs. Throws as check_disturbance().
void disturb(StereoPair& pair, const Disturbance& disturbance);

}  // namespace hexrelief::bench::match
