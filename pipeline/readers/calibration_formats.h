// The calibration files' formats, each from text; what they share.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "pipeline/data/calibration.h"

namespace hexrelief::codec {

// Where a calibration's text came from, for messages.
struct CalibrationText {
    std::filesystem::path path;
    std::string text;  // no NUL bytes, no byte order mark
};

// Each returns nullopt where the text is not in its format, and throws Error(input) naming file and key where
// it is but is wrong. The own and OpenCV forms share YAML.
std::optional<Calibration> parse_middlebury(const CalibrationText& source);
std::optional<Calibration> parse_kitti(const CalibrationText& source);
std::optional<Calibration> parse_yaml(const CalibrationText& source);

// "cannot read 'PATH': KEY REASON"
[[noreturn]] void refuse_key(const CalibrationText& source, std::string_view key, const std::string& reason);

// A finite number under `key`, or a refusal.
double require_number(const CalibrationText& source, std::string_view key, std::string_view text);

// A whole number of pixels, at least 1, or a refusal.
int require_side(const CalibrationText& source, std::string_view key, double value);

// Refuses focal lengths that differ (pixels that are not square): Calibration has one.
void require_square(const CalibrationText& source, std::string_view key, double fx, double fy);

// Files that count the centre of pixel 0 as 0 hold principal points half a pixel less than Calibration does.
inline constexpr double kPixelCentre = 0.5;

// A 3x4 projection matrix, row-major.
using Projection = std::array<double, 12>;

// Of two rectified cameras side by side with one focal length, which is not 0.
Calibration from_projections(const Projection& left, const Projection& right);

}  // namespace hexrelief::codec
