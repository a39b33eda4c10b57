// The synthetic pair as files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace hexrelief::samples {

struct SampleFile {
    std::string name;
    std::vector<std::uint8_t> bytes;
};

// left.png, right.png, disparity.pfm and calib.txt.
std::vector<SampleFile> sample_files();

// left.png and right.png of render_photographs().
std::vector<SampleFile> photograph_files();

// All or none of them, into a folder that exists. Throws Error(output).
void write_sample_files(const std::vector<SampleFile>& files, const std::filesystem::path& folder);

}  // namespace hexrelief::samples
