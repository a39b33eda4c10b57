// What a run works on, read and made fit for the stages.
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/job/request.h"
#include "pipeline/job/run_log.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

// A pair side by side, as it is matched.
struct InputPair {
    StereoPair views;
    bool is_rectified = false;  // by its calibration file
};

// A supplied map: its disparities, or those of its depths.
struct InputMap {
    DisparityMap disparities;
    Image color;                // the left picture at the map's size; empty = none
    Image picture;              // the same as it came, where its size is not the map's; else empty
    std::string depth_read_as;  // of a map of depths: "16-bit integers, mm"; else empty

    bool is_depth() const { return !depth_read_as.empty(); }
};

struct RunInput {
    std::variant<InputPair, InputMap> views;
    // Of the left view: what its map is to keep once it is matched or filled; empty = all. Of a map that was
    // supplied what is not kept is unknown already.
    readers::PixelMask mask = {};
    Calibration calibration = {};  // in effect, of the left view's size
    std::string focal_from = {},
                baseline_from = {};  // as ResolvedCalibration has them, or "the nearest distance"
    std::vector<InputFile> files = {};

    const InputPair* pair() const { return std::get_if<InputPair>(&views); }
    const InputMap* map() const { return std::get_if<InputMap>(&views); }
    // The left picture at the size of the view, and as it came; empty = none.
    const Image& color() const { return pair() ? pair()->views.left : map()->color; }
    const Image& texture() const { return map() && !map()->picture.empty() ? map()->picture : color(); }
};

// left_rectified.png right_rectified.png calib.txt: what save_rectified() writes.
const std::vector<std::filesystem::path>& rectified_file_names();

// Takes the arrays out of the source. Warns of a missing calibration. Throws Error(input) where a file cannot
// be read or sizes differ.
RunInput read_input(Source source, const config::InputConfig& config, const readers::ReaderLimits& limits,
                    int threads, RunLog& log);

}  // namespace hexrelief::job
