// Calibrations, as `hexrelief info` tells them.
#pragma once

#include <filesystem>

#include "pipeline/cli/info/told_lines.h"

namespace hexrelief::cli::info {

// Adds the calibration in a file, of one camera or of a pair to rectify. Throws Error(input).
void tell_calibration_of(const std::filesystem::path& path, Text& text);
// Adds the calibration in a file of arrays; false if the file is no camera, but perhaps a map.
bool tell_if_calibration(const std::filesystem::path& path, Text& text);

}  // namespace hexrelief::cli::info
