// The files that a run reads.
#pragma once

#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/depth_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/job/request.h"
#include "pipeline/job/run_log.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

struct InputFile {
    // "left", "right", "stereo", "disparity", "depth", "color", "calibration", "mask", "confidence"
    std::string role;
    std::string path;
    std::string sha256;
};

// What the numbers of the input were taken for.
struct InputBeliefs {
    std::string focal_from, baseline_from;  // as ResolvedCalibration has them, or "the nearest distance"
    std::string depth;                      // of a depth map: "16-bit integers, mm"; else empty
};

// Either a pair, or a map with or without the left image.
struct RunInput {
    StereoPair pair;   // right is empty where a map is given; left too where there is no image
    Image picture;     // the left image as it came, where its size is not the map's; else empty
    DisparityMap map;  // empty where a pair is given
    // Of the left view: what its map is to keep once it is matched or filled; empty = all. What was read is
    // hidden already.
    readers::PixelMask mask;
    Calibration calibration;    // in effect
    bool is_rectified = false;  // the pair, by its calibration file
    InputBeliefs believed;
    std::vector<InputFile> files;

    bool is_pair() const { return !pair.right.empty(); }
    const Image& texture() const { return picture.empty() ? pair.left : picture; }
};

// left_rectified.png right_rectified.png calib.txt: what save_rectified() writes.
const std::vector<std::filesystem::path>& rectified_file_names();

// Warns of a missing calibration. Throws Error(input) where a file cannot be read or sizes differ, and
// Error(usage) where a rectified pair would be saved over one of the inputs.
RunInput read_input(const RunRequest& request, int threads, RunLog& log);

// A map that is in memory, with its picture and masks; empty = none.
struct MapArrays {
    DisparityMap disparity = {};  // empty where depths are given
    readers::DepthFile depth = {};
    Image color = {};
    readers::PixelMask mask = {}, confidence = {};
};

// The same of a rectified pair, or of a map, that are in memory: the request says the rest, and names no file
// of theirs, but that request.depth is not empty where the map is one of depths. Throw likewise. A pair is
// taken for its disparities alone: without a calibration there is nothing to warn of.
RunInput take_pair(StereoPair pair, const RunRequest& request, RunLog& log);
RunInput take_map(MapArrays arrays, const RunRequest& request, RunLog& log);

}  // namespace hexrelief::job
