// Rectifies a pair by its calibration file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::job {

struct FileRectification {
    bool is_done = false;  // false: the pair is left as it is
    Calibration calibration = {};
    std::vector<std::uint8_t> seen = {};    // as in RectifiedPair
    std::filesystem::path other_file = {};  // the second calibration file that was read; empty = none
    std::vector<std::string> warnings = {}, decisions = {};
};

// Replaces the views by the rectified ones if the configuration's file tells of the cameras as they took the
// pictures. If it tells of rectified pictures as well, the rows of the pair decide which of both it is.
// Throws Error(input) if the file is for a size of another aspect, and what reading it and rectify() throw.
FileRectification rectify_by_file(StereoPair& views, const config::InputConfig& config, int threads);

}  // namespace hexrelief::job
