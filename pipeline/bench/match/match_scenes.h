// The pairs of `hexrelief bench match`: how they are found in a folder, and how they are disturbed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::bench::match {

namespace fs = std::filesystem;

struct ScenePair {
    std::string name;  // the name of its folder, such as cones-quarter; with -color for a second pair in it
    std::string size;  // small, half or full: rows of the same size are averaged together
    fs::path left, right, truth;
    fs::path right_truth;  // may be empty
    double scale = 1;      // raw value / scale = px
    double discontinuity_px = 1;
};

// Returns a pair for every folder below `data` that holds left.*, right.* and disp.*, in the order of their
// paths; left_color.* and right_color.*, if present, are a second pair. Middlebury's scales are assumed: 16
// for tsukuba, 8 for other scenes below middlebury2001, 1 for floats; otherwise 4, 3, 2, 1 for names that end
// in -quarter, -third, -half, -full. `left_out` gets a line for each folder of unknown scale. Throws
// Error(input) if there is no such folder.
std::vector<ScenePair> find_scenes(const fs::path& data, std::vector<std::string>& left_out);

// Sensor noise and a difference in light. Neutral by default.
struct Disturbance {
    // Standard deviation in every sample of both images, in percent of 255; 0..100.
    double noise_percent = 0;
    double gamma = 1, gain = 1;  // of the right view: 255 * gain * (v / 255)^gamma; above 0
};
// Throws Error(usage) if a number is out of its range.
void check_disturbance(const Disturbance& disturbance);
// Changes the light first, then adds noise. The result is the same on every machine.
// Throws what check_disturbance() throws.
void disturb(StereoPair& pair, const Disturbance& disturbance);

}  // namespace hexrelief::bench::match
