// One page that lists the results in a folder, with thumbnails and figures.
#pragma once

#include <cstddef>
#include <filesystem>

namespace hexrelief::gallery {

// Results are the pages (.html) that hexrelief has written into `folder` and those below it, and the meshes
// of reports (.json) there; both of one run are one row. Writes the page to `path` and returns how many
// results it lists. Throws Error(usage) where this program was built without its viewer, Error(input) where
// folder holds no result, Error(output).
std::size_t write_gallery(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace hexrelief::gallery
