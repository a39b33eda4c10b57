// The names of formats and of the files that they consist of.
#pragma once

#include <filesystem>
#include <string>

namespace hexrelief::exporters {

// Returns the extension in lower case, with the dot.
std::string extension_of(const std::filesystem::path& path);

// Returns the path of a level of detail in a file of its own: "<stem>.lod<level><extension>", level >= 1.
std::filesystem::path level_path(const std::filesystem::path& path, int level);

}  // namespace hexrelief::exporters
