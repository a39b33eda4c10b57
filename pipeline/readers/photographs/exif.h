// EXIF data in photographs, and the orientation that they tell.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::readers {

// Returns the EXIF data of a JPEG, PNG, WebP or HEIC file, which form a TIFF file of their own; empty if it
// has none or is malformed. Throws Error(input) if the file cannot be opened.
std::vector<std::uint8_t> read_exif(const std::filesystem::path& path);

// An orientation of EXIF and TIFF: 1 = upright as stored; 2 mirrored; 3 turned by half; 4 upside down; 6 and
// 8 to be turned by a quarter, clockwise and counter-clockwise; 5 and 7 these mirrored.
inline constexpr int kUpright = 1;
inline bool is_quarter_turn(int orientation) {
    return orientation >= 5;
}

// Returns the orientation that a JPEG, PNG, WebP or TIFF file states; kUpright if it states none. That of a
// HEIC file is applied by its decoder. Throws Error(input) if the file cannot be opened.
int read_orientation(const std::filesystem::path& path);

// Returns the picture as it is to be seen.
Image upright(Image image, int orientation);

// Returns "turned by a quarter clockwise": what upright() does.
std::string orientation_text(int orientation);

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
