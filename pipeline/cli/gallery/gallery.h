// Makes one page that lists the results in a folder, with thumbnails and figures.
#pragma once

#include <cstddef>
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

// Writes the page to `path` and returns the number of results that it lists. Results are the pages (.html)
// that hexrelief has written into `folder` and the folders below it, and the meshes of reports (.json) there;
// both of one run are one row. Throws Error(usage) if this program was built without its viewer, Error(input)
// if the folder holds no result, Error(output).
std::size_t write_gallery(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace hexrelief::cli
