// The synthetic pair as files.
#pragma once

#include <filesystem>

namespace hexrelief {

// left.png, right.png, disparity.pfm and calib.txt, in a folder that exists. Throws Error(output).
void write_sample_files(const std::filesystem::path& folder);

}  // namespace hexrelief
