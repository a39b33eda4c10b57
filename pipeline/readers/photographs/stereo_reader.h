// Reads files that hold both pictures of a pair.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

// The layout of both pictures in a file: side by side or one above the other. In the half forms each picture
// was squeezed to half of its width or height, and is stretched again.
enum class StereoLayout { automatic, side_by_side, half_side_by_side, top_bottom, half_top_bottom, mpo };

struct StereoFileConfig {
    // automatic: both pictures of a spatial HEIC photograph; mpo if the file holds two JPEG pictures;
    // side_by_side with the right view first, as these formats have it, if the name ends in .jps or .pns,
    // unless the file has JPS's descriptor, which says layout and order.
    StereoLayout layout = StereoLayout::automatic;
    bool right_first = false;  // the right view is on the left, or above: cross-eyed
};

struct StereoViews {
    StereoPair views;
    Calibration camera = {};      // of the left view, as the file says it; a focal length of 0 = it says none
    std::string told = {};        // how the views lie in the file, and what said so
    bool is_right_first = false;  // the file has the right view first, by its own word
};

// Reads a pair, both views turned as the first picture's EXIF orientation says if `is_upright`. In MPO files
// the left view comes first, unless the views' numbers say otherwise. The middle column or row of a picture
// with an odd side belongs to no half. Throws Error(input) as read_image() does, and if the layout is
// automatic and nothing tells it, if the file cannot be halved, or if its two pictures differ in size.
StereoViews read_stereo_file(const std::filesystem::path& path, const StereoFileConfig& config,
                             const ReaderLimits& limits = {}, bool is_upright = true);

// True if words of the file's name say its layout, as in holiday-sbs.jpg: read_stereo_file() then believes
// them if the layout is automatic and the file itself says nothing.
bool names_layout(const std::filesystem::path& path);

struct StereoFileDescription {
    int width = 0, height = 0;  // of each view, as stored
    Calibration camera = {};
    std::string told;  // as in StereoViews
};
// Describes a file of which read_stereo_file() would find both views without a given layout, from its
// headers; nullopt for other files. Throws Error(input) if a picture's header is malformed.
std::optional<StereoFileDescription> describe_stereo_file(const std::filesystem::path& path,
                                                          const ReaderLimits& limits = {});

// Returns a line for each picture of a JPEG or HEIC file that holds several, as "80 x 60 px, left view"; none
// for other files. Throws Error(input) if the file cannot be opened.
std::vector<std::string> list_pictures(const std::filesystem::path& path, const ReaderLimits& limits = {});

}  // namespace hexrelief::readers
