// Reads files that hold both pictures of a pair.
#pragma once

#include <filesystem>

#include "pipeline/data/disparity_map.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

// The layout of both pictures in a file: side by side or one above the other. In the half forms each picture
// was squeezed to half of its width or height, and is stretched again.
enum class StereoLayout { automatic, side_by_side, half_side_by_side, top_bottom, half_top_bottom, mpo };

struct StereoFileConfig {
    StereoLayout layout = StereoLayout::automatic;  // automatic: MPO, if the file is one
    bool right_first = false;                       // the right view is on the left, or above: cross-eyed
};

// Reads a pair. In MPO files the left view comes first. Throws Error(input) as read_image() does, and if
// the layout is automatic and the file is not an MPO, if the file cannot be halved, or if an MPO's
// pictures differ in size.
StereoPair read_stereo_file(const std::filesystem::path& path, const StereoFileConfig& config,
                            const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
