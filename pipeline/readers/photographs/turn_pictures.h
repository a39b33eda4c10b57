// Turns the pictures of a run as their EXIF orientation says.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/image.h"
#include "pipeline/readers/photographs/exif.h"

namespace hexrelief::readers {

struct OrientedPicture {
    Image image;
    std::filesystem::path path;  // for messages
    int orientation = kUpright;  // to be applied
};

struct Turning {
    std::vector<std::string> decisions = {}, warnings = {};
};

// Turns a pair's pictures, unless only the stored pictures have one size. If the pair has a calibration, it
// may be for the pictures as stored, and a warning says so.
Turning turn_upright(OrientedPicture& left, OrientedPicture& right, bool has_calibration);

// Turns the picture of a map of width x height px by a quarter if that brings its aspect closer to the map's.
// Warns if the aspects do not tell whether the map is of the picture as stored or as seen.
Turning turn_to_fit(OrientedPicture& color, int width, int height);

}  // namespace hexrelief::readers
