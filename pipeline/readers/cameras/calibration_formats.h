// The parsers of the calibration formats, and the functions that they share.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::readers::codec {

// The text of a calibration file, and what its format says about it besides the numbers.
struct CalibrationText {
    std::filesystem::path path;                // for error messages
    std::string text;                          // without NUL bytes and byte order mark
    std::string format = {};                   // set by the parser that accepts the text
    bool has_baseline = true;                  // false: the file describes a single camera
    std::vector<std::string> told;             // assumptions that may be wrong, a sentence each
    int width = 0, height = 0;                 // of the pictures; 0 = not known
    std::vector<std::filesystem::path> views;  // the map and the picture
};

// Loads a calibration file. A matrix saved by NumPy and COLMAP's cameras.bin are converted to text. Throws
// Error(input) if the file cannot be read, is too large, or contains other NUL bytes.
CalibrationText load_calibration_text(const std::filesystem::path& path);

// Returns the lines of cameras.txt that say the same as COLMAP's cameras.bin; nullopt for other bytes.
std::optional<std::string> text_of_colmap(const std::vector<std::uint8_t>& bytes);

// Parse one format each. They return nullopt if the text is not in their format, and throw Error(input)
// naming file and key if it is but has an error.
std::optional<Calibration> parse_middlebury(CalibrationText& source);
std::optional<Calibration> parse_kitti(CalibrationText& source);
std::optional<Calibration> parse_colmap(CalibrationText& source);
std::optional<Calibration> parse_matrix(CalibrationText& source);
std::optional<Calibration> parse_mvsnet(CalibrationText& source);

// Returns digits that read back as the same number.
inline std::string exact_text(double number) {
    return number_text(number, 17);
}

// Throws Error(input): "cannot read 'PATH': KEY REASON".
[[noreturn]] void refuse_key(const CalibrationText& source, std::string_view key, const std::string& reason);

// Returns the finite number under `key`, or refuses.
double require_number(const CalibrationText& source, std::string_view key, std::string_view text);

// Returns a whole number of pixels, at least 1, or refuses.
int require_side(const CalibrationText& source, std::string_view key, double value);

// Returns the mean of the two focal lengths, since Calibration has only one; if they differ, this is added to
// source.told. Refuses lengths that differ by more than 1 % (pixels that are not square).
double require_square(CalibrationText& source, std::string_view key, double fx, double fy);

// Refuses two views whose focal lengths differ by more than 0.5 %.
void require_one_focal(const CalibrationText& source, std::string_view key, double left, double right);

// In files that count the centre of pixel 0 as 0, principal points are half a pixel less than in Calibration.
inline constexpr double kPixelCentre = 0.5;

// A 3x4 projection matrix, row-major.
using Projection = std::array<double, 12>;

// Returns the calibration of two rectified cameras side by side with one focal length, which must not be 0.
Calibration from_projections(const Projection& left, const Projection& right);

// One camera, as files describe it. `width` and `height` are 0 if unknown.
struct Pinhole {
    double fx = 0, fy = 0, cx = 0, cy = 0;
    int width = 0, height = 0;
};

// Returns the 9 numbers of K, which 9, 12 (3x4) or 16 (4x4) numbers begin with, row-major.
std::vector<double> upper_left(const std::vector<double>& matrix);

// Returns the camera of a 3x3 matrix, row-major or column-major: K's last row is 0 0 1, so
// the zeros tell which.
Pinhole from_matrix(const CalibrationText& source, std::string_view key, const std::vector<double>& matrix);

// Returns a calibration without a baseline. The file counts the centre of pixel 0 as 0.5 - pixel_centre.
Calibration from_pinhole(CalibrationText& source, std::string_view key, const Pinhole& camera,
                         double pixel_centre = kPixelCentre);

}  // namespace hexrelief::readers::codec
