// The calibration files' formats, each from text; what they share.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/data/calibration.h"

namespace hexrelief::readers::codec {

// A calibration's text, and what its format says of it besides the numbers.
struct CalibrationText {
    std::filesystem::path path;     // for messages
    std::string text;               // no NUL bytes, no byte order mark
    std::string format = {};        // set by the reader that takes the text
    bool has_baseline = true;       // false: the file is of one camera
    std::vector<std::string> told;  // what was believed and may be wrong, a sentence each
};

// An array of 3x3 numbers that NumPy saved becomes their text. Throws Error(input) where the file cannot be
// read, is too large, or holds other NUL bytes.
CalibrationText load_calibration_text(const std::filesystem::path& path);

// Each returns nullopt where the text is not in its format, and throws Error(input) naming file and key where
// it is but is wrong. All that is YAML or JSON is read by parse_yaml().
std::optional<Calibration> parse_middlebury(CalibrationText& source);
std::optional<Calibration> parse_kitti(CalibrationText& source);
std::optional<Calibration> parse_colmap(CalibrationText& source);
std::optional<Calibration> parse_matrix(CalibrationText& source);
std::optional<Calibration> parse_yaml(CalibrationText& source);

// "cannot read 'PATH': KEY REASON"
[[noreturn]] void refuse_key(const CalibrationText& source, std::string_view key, const std::string& reason);

// A finite number under `key`, or a refusal.
double require_number(const CalibrationText& source, std::string_view key, std::string_view text);

// A whole number of pixels, at least 1, or a refusal.
int require_side(const CalibrationText& source, std::string_view key, double value);

// The mean of the two focal lengths, since Calibration has one. Refuses those that differ by more than 1 %
// (pixels that are not square); told where they differ at all.
double require_square(CalibrationText& source, std::string_view key, double fx, double fy);

// Refuses the two views' focal lengths where they differ by more than 0.5 %.
void require_one_focal(const CalibrationText& source, std::string_view key, double left, double right);

// Files that count the centre of pixel 0 as 0 hold principal points half a pixel less than Calibration does.
inline constexpr double kPixelCentre = 0.5;

// A 3x4 projection matrix, row-major.
using Projection = std::array<double, 12>;

// Of two rectified cameras side by side with one focal length, which is not 0.
Calibration from_projections(const Projection& left, const Projection& right);

// One camera, as files hold it. `width` and `height` are 0 where they are not said.
struct Pinhole {
    double fx = 0, fy = 0, cx = 0, cy = 0;
    int width = 0, height = 0;
};

// The camera of a 3x3 matrix, row-major or column-major: K's last row is 0 0 1, so the zeros tell which.
Pinhole from_matrix(const CalibrationText& source, std::string_view key, const std::vector<double>& matrix);

// Without a baseline. The file counts the centre of pixel 0 as `pixel_centre` less than 0.5.
Calibration from_pinhole(CalibrationText& source, std::string_view key, const Pinhole& camera,
                         double pixel_centre = kPixelCentre);

}  // namespace hexrelief::readers::codec
