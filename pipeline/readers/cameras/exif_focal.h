// Reads the focal length from a photograph's EXIF data.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace hexrelief::readers {

struct ExifFocal {
    double focal_px = 0;   // above 0, for the picture at the given size
    std::string believed;  // the source of the value: "28 mm on 35 mm film"
};

// Returns the focal length of a photograph of width x height px: from FocalLengthIn35mmFilm, whose 36 x 24 mm
// have the picture's diagonal angle of view, else from FocalLength and the sensor's FocalPlaneXResolution;
// both refer to the whole picture as it was taken. Returns nullopt if the file has no EXIF
// data (exif.h), or they have neither or are damaged. Throws Error(input) if the file cannot be opened.
std::optional<ExifFocal> read_exif_focal(const std::filesystem::path& path, int width, int height);

}  // namespace hexrelief::readers
