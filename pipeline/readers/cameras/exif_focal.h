// The focal length that a photograph's EXIF data tell.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace hexrelief::readers {

struct ExifFocal {
    double focal_px = 0;   // above 0, of the picture at the size given
    std::string believed;  // "28 mm on 35 mm film"
};

// Of a JPEG file of width x height px, from FocalLengthIn35mmFilm, whose 36 x 24 mm have the picture's
// diagonal angle of view, else from FocalLength and the sensor's FocalPlaneXResolution; both belong to the
// whole picture as it was taken. nullopt where the file is no JPEG, or tells neither. Throws Error(input)
// where it cannot be opened; damaged EXIF data count as none.
std::optional<ExifFocal> read_exif_focal(const std::filesystem::path& path, int width, int height);

}  // namespace hexrelief::readers
