// A small synthetic rectified pair whose disparities are known exactly, and its files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::samples {

struct SampleScene {
    StereoPair pair;          // colour
    DisparityMap disparity;   // of the left view at the pixels' centres, known also where the right is blind
    Calibration calibration;  // metric
};

// 320x240, disparities of about 4 to 40 px: a far background, a slanted floor and a slanted wall, three
// spheres, thin upright and leaning bars. Needs only + - * / sqrt and integer hashes: the same bytes wherever
// doubles are IEEE.
SampleScene render_sample_scene();

// The same scene as two photographs by hand: 640x480, the cameras turned towards each other and out of line,
// through lenses that bend, and cut so that what is 2 m away has a disparity of 0 (a stereo window).
StereoPair render_photographs();

// A file of the synthetic pair.
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
