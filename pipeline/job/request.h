// The request of a run: source, outputs and configuration.
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

// Alternatives of a run's source, files first. Masks, confidences and colours may be empty, which means none;
// masks and confidences are for the left view.
struct PairFiles {
    std::filesystem::path left, right, mask = {};
};
// One file with both views.
struct StereoFile {
    std::filesystem::path file, mask = {};
};
// color: the left picture. right, color_right: the right view's map and picture.
struct DisparityFiles {
    std::filesystem::path map, color = {}, mask = {}, confidence = {}, right = {}, color_right = {};
};
struct DepthFiles {
    std::filesystem::path map, color = {}, mask = {}, confidence = {};
};

// Arrays in memory; an empty array means none. A pair is rectified; a missing calibration gives no warning,
// because the library takes such pairs for their disparities alone.
struct PairArrays {
    StereoPair views;
};
struct DisparityArrays {
    readers::DisparityFile map;
    Image color = {};
    readers::PixelMask mask = {}, confidence = {};
};
struct DepthArrays {
    readers::DepthFile map;
    Image color = {};
    readers::PixelMask mask = {}, confidence = {};
};

using Source =
    std::variant<PairFiles, StereoFile, DisparityFiles, DepthFiles, PairArrays, DisparityArrays, DepthArrays>;

struct InputFile {
    // "left", "right", "stereo", "disparity", "depth", "color", "calibration", "mask", "confidence",
    // "disparity right", "color right"
    std::string role;
    std::string path;
    std::string sha256 = {};  // set after the file is read
};

// Returns the named files of a source, the main one first; none for arrays.
std::vector<InputFile> files_of(const Source& source);

struct RunRequest {
    Source source = {};
    std::vector<std::filesystem::path> outputs = {};  // the extension gives the format
    config::Config config = {};
    std::vector<std::filesystem::path> config_files = {};  // that config was read from
    std::filesystem::path report = {};                     // empty = none
    std::filesystem::path stages_folder = {};              // empty = none
    std::filesystem::path depfile = {};  // rule for make that lists the files read; empty = none
    std::string stamp = {};              // hash of what the outputs depend on (stamp.h); empty = none
    int jobs = 1;  // runs of this process, including this one; they share one start of the device
};

// Checks all that can be checked before the work. Throws Error(usage) for unknown extensions and for an
// output that is named twice or is an input, Error(output) for a place that cannot be written, and
// Error(input) if the estimated memory exceeds limits.max_memory.
void check_request(const RunRequest& request);

}  // namespace hexrelief::job
