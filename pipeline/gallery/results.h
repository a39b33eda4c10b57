// The results that a folder holds.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::gallery {

// NaN where it is not known.
struct ResultFigures {
    double vertices, triangles, bytes, percent_cost, error_px, seconds;
};

struct FoundResult {
    std::filesystem::path file;  // to be opened: a page, or else the mesh that a report names
    std::string picture;         // a data: address; empty = none
    ResultFigures figures;
};

// In the order of their files' names. Files that are no pages and no reports are passed over, and so are
// folders that cannot be read.
std::vector<FoundResult> find_results(const std::filesystem::path& folder);

}  // namespace hexrelief::gallery
