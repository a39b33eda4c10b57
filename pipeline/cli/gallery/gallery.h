// Makes one page that lists the results in a folder, with thumbnails and figures.
#pragma once

#include <cstddef>
#include <filesystem>

namespace hexrelief::cli {

// Writes the page to `path` and returns the number of results that it lists. Results are the pages (.html)
// that hexrelief has written into `folder` and the folders below it, and the meshes of reports (.json) there;
// both of one run are one row. Throws Error(usage) if this program was built without its viewer, Error(input)
// if the folder holds no result, Error(output).
std::size_t write_gallery(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace hexrelief::cli
