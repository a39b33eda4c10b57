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
    // automatic: both pictures of a spatial HEIC photograph; mpo if the file holds two JPEG pictures;
    // side_by_side with the right view first, as these formats have it, if the name ends in .jps or .pns.
    StereoLayout layout = StereoLayout::automatic;
    bool right_first = false;  // the right view is on the left, or above: cross-eyed
};

// Reads a pair. In MPO files the left view comes first. The middle column or row of a picture with an odd
// side belongs to no half. Throws Error(input) as read_image() does, and if the layout is automatic and
// nothing tells it, if the file cannot be halved, or if its two pictures differ in size.
StereoPair read_stereo_file(const std::filesystem::path& path, const StereoFileConfig& config,
                            const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
