// The paper's maps in a folder with Middlebury's sets.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::paper {

struct PaperMap {
    std::string name, folder;
    double scale;  // raw value / scale = px
    int ssr;       // in the paper's Table 2
};

struct FoundMap {
    PaperMap map;
    std::filesystem::path path;
};

// Returns the paper's maps that are there. Throws Error(input) if there are none.
std::vector<FoundMap> find_maps(const std::filesystem::path& data);

// Reads a map, in px. Throws Error(input).
DisparityMap load_map(const FoundMap& found);

}  // namespace hexrelief::paper
