// The benchmarks' maps: names given on the command line, files in a folder with Middlebury's sets.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/bench/table2_paper.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::bench {

// Throws Error(usage) naming the option where `given` holds a name that is not among the known ones.
void check_names(const std::vector<std::string>& given, const std::vector<std::string>& known,
                 const char* option);
// True where the name is given or none is.
bool wanted(const std::vector<std::string>& names, const std::string& name);

struct FoundMap {
    const table2::PaperMap* map;
    std::filesystem::path path;
};

// The paper's maps that are in one of `sets` (the paper's names; empty = all), among `names` (empty = all)
// and in the folder `data`; `missing` gets a line for each that the folder lacks. Throws Error: usage for a
// name that is not known, input where there is no such folder or none of the maps in it.
std::vector<FoundMap> find_maps(const std::filesystem::path& data, const std::vector<std::string>& sets,
                                const std::vector<std::string>& names, std::vector<std::string>& missing);

// In px. Throws Error(input).
DisparityMap load_map(const FoundMap& found);

}  // namespace hexrelief::bench
