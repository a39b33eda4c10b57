// What a file holds beside its first picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

// Returns a line for each picture of a JPEG or HEIC file that holds several, as "80 x 60 px, left view"; none
// for other files. Throws Error(input) if the file cannot be opened.
std::vector<std::string> list_pictures(const std::filesystem::path& path, const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
