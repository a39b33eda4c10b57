// Joins many GLB files into one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/file_transaction.h"

namespace hexrelief::tileset {

// Writes a GLB whose scene has the nodes of the scenes of all `parts`, which export_scene() wrote; each keeps
// its mesh, texture and compression unchanged. Memory: the parts' JSON and one part's data. Throws
// Error(input) if a part cannot be read, Error(output) if the result is 4 GiB or more.
void join_glb(const std::vector<std::filesystem::path>& parts, const std::string& generator,
              const std::filesystem::path& path, exporters::FileTransaction& files);

}  // namespace hexrelief::tileset
