// The maps of the benchmarks: names given on the command line, and files in a folder with Middlebury's sets.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/bench/table2_paper.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::bench {

// Throws Error(usage) naming the option if one of `given` is not a known name.
void check_names(const std::vector<std::string>& given, const std::vector<std::string>& known,
                 const char* option);
// True if the name is given, or if no names are given.
bool wanted(const std::vector<std::string>& names, const std::string& name);

struct FoundMap {
    const table2::PaperMap* map;
    std::filesystem::path path;
};

// Returns the paper's maps that are in one of `sets` (the paper's names; empty = all), among `names` (empty =
// all) and in the folder `data`; `missing` gets a line for each map that the folder lacks. Throws
// Error(usage) for an unknown name, Error(input) if there is no such folder or it has none of the maps.
std::vector<FoundMap> find_maps(const std::filesystem::path& data, const std::vector<std::string>& sets,
                                const std::vector<std::string>& names, std::vector<std::string>& missing);

// Reads a map, in px. Throws Error(input).
DisparityMap load_map(const FoundMap& found);

}  // namespace hexrelief::bench
