// Middlebury's scenes, each with its pair, its map and its camera as far as these are published.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks::mistakes {

struct SceneFiles {
    const char *folder, *left, *right, *map;  // left, right: nullptr if there are none
    double scale;                             // of the map
    double focal_px, baseline_m, doffs_px;    // 0 = not published
};

struct TestScene {
    const SceneFiles* files;
    std::string name;
    StereoPair pair;  // empty if there are no pictures
    DisparityMap map;
    double largest_px = 0;
};

// Loads the scenes in the folder `data` whose names contain `wanted`.
std::vector<TestScene> load(const std::filesystem::path& data, const std::string& wanted);

}  // namespace hexrelief::checks::mistakes
