// Finds the results in a folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::cli {

// The figures of a result; NaN = unknown.
struct ResultFigures {
    double vertices, triangles, bytes, percent_cost, error_px, seconds;
};

struct FoundResult {
    std::filesystem::path file;  // the file to open: a page, or else the mesh that a report names
    std::string picture;         // a data: URL; may be empty
    ResultFigures figures;
};

// Returns the results in the order of their files' names. Files that are neither pages nor reports are
// skipped, and so are folders that cannot be read.
std::vector<FoundResult> find_results(const std::filesystem::path& folder);

}  // namespace hexrelief::cli
