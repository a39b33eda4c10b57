// What a run is asked for.
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

// What a run can be made from. Files first; but for the first of each, names may be empty, which is none.
// Masks and confidences are of the left view.
struct PairFiles {
    std::filesystem::path left, right, mask = {};
};
// Both views in one file.
struct StereoFile {
    std::filesystem::path file, mask = {};
};
// color: the left picture.
struct DisparityFiles {
    std::filesystem::path map, color = {}, mask = {}, confidence = {};
};
struct DepthFiles {
    std::filesystem::path map, color = {}, mask = {}, confidence = {};
};

// The same in memory; empty arrays are none. A pair is side by side, and taken for its disparities alone:
// without a calibration there is nothing to warn of.
struct PairArrays {
    StereoPair views;
};
struct DisparityArrays {
    DisparityMap map;
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
    // "left", "right", "stereo", "disparity", "depth", "color", "calibration", "mask", "confidence"
    std::string role;
    std::string path;
    std::string sha256 = {};  // once it is read
};

// The files of a source that are named, the main one first; none where it is in memory.
std::vector<InputFile> files_of(const Source& source);

struct RunRequest {
    Source source;
    std::vector<std::filesystem::path> outputs;  // share the work; the extension gives the format
    config::Config config;
    std::filesystem::path config_file;    // that config was read from; empty = none
    std::filesystem::path report;         // empty = none
    std::filesystem::path stages_folder;  // empty = none
    std::filesystem::path depfile;        // for make: what the outputs are made from; empty = none
    std::string stamp;  // told in the report: of all that the outputs depend on (stamp.h); empty = not
    int jobs = 1;       // that this process does, this one included: they share a device's start-up
};

// Everything that can be known to fail before the work: throws Error(usage) for unknown extensions, an output
// that is named twice or is an input, Error(output) for a place that cannot be written, and Error(input) for
// a run that is estimated to take more memory than limits.max_memory.
void check_request(const RunRequest& request);

}  // namespace hexrelief::job
