#include "pipeline/readers/calibration_reader.h"

#include <cmath>

#include "pipeline/readers/calibration_formats.h"
#include "pipeline/readers/source.h"
#include "pipeline/readers/text.h"

namespace hexrelief {
namespace codec {

void refuse_key(const CalibrationText& source, std::string_view key, const std::string& reason) {
    refuse(source.path, std::string(key) + " " + reason);
}

double require_number(const CalibrationText& source, std::string_view key, std::string_view text) {
    if (const auto value = parse_number(text)) return *value;
    refuse_key(source, key, "is " + excerpt(trim(text)) + "; it must be a finite number");
}

int require_side(const CalibrationText& source, std::string_view key, double value) {
    if (value >= 1 && value <= 1e9 && value == std::floor(value)) return static_cast<int>(value);
    refuse_key(source, key, "must be a whole number of pixels, at least 1");
}

void require_square(const CalibrationText& source, std::string_view key, double fx, double fy) {
    // Rectified pairs have square pixels; files round to a few digits.
    if (std::abs(fx - fy) <= 0.005 * std::abs(fx)) return;
    refuse_key(source, key,
               "has focal lengths " + std::to_string(fx) + " and " + std::to_string(fy) +
                   "; rectified images have square pixels, scale them first");
}

Calibration from_projections(const Projection& left, const Projection& right) {
    Calibration calibration;
    calibration.focal_px = left[0];
    calibration.cx = left[2] + kPixelCentre;
    calibration.cy = left[6] + kPixelCentre;
    calibration.baseline_m = left[3] / left[0] - right[3] / right[0];
    calibration.doffs_px = right[2] - left[2];
    return calibration;
}

}  // namespace codec

namespace {

codec::CalibrationText load_text(const std::filesystem::path& path) {
    constexpr std::uintmax_t longest = 1u << 18;  // real ones have a few KiB
    const codec::SourceFile source = codec::load_file(path, longest);
    std::string text(source.bytes.begin(), source.bytes.end());
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
    if (text.find('\0') != std::string::npos) {
        codec::refuse(path,
                      "it is a binary file, not a calibration text; give calib.txt, KITTI or OpenCV YAML");
    }
    return {path, std::move(text)};
}

// Focal length and baseline above 0 and everything finite: else later stages divide by 0.
void check_possible(const std::filesystem::path& path, const Calibration& calibration) {
    const auto number = [](double value) { return std::to_string(value); };
    if (!(calibration.focal_px > 0) || !std::isfinite(calibration.focal_px)) {
        codec::refuse(path,
                      "the focal length is " + number(calibration.focal_px) + " px; it must be above 0");
    }
    if (!(calibration.baseline_m > 0) || !std::isfinite(calibration.baseline_m)) {
        codec::refuse(path, "the baseline is " + number(calibration.baseline_m) +
                                " m; it must be above 0 (left and right swapped?)");
    }
    if (!std::isfinite(calibration.cx) || !std::isfinite(calibration.cy) ||
        !std::isfinite(calibration.doffs_px)) {
        codec::refuse(path, "principal point and disparity offset must be finite numbers");
    }
}

}  // namespace

Calibration read_calibration(const std::filesystem::path& path) {
    const codec::CalibrationText source = load_text(path);
    if (codec::trim(source.text).empty()) codec::refuse(path, "the file is empty; give a calibration");
    if (codec::trim(source.text).starts_with('<')) {
        codec::refuse(path, "XML is not supported; save OpenCV's calibration as .yml");
    }
    for (const auto parse : {codec::parse_middlebury, codec::parse_kitti, codec::parse_yaml}) {
        if (auto calibration = parse(source)) {
            calibration->metric = true;
            check_possible(path, *calibration);
            return *calibration;
        }
    }
    codec::refuse(
        path,
        "not a calibration that is known; give Middlebury's calib.txt (cam0=, baseline=), KITTI's (P2:, "
        "P3:), OpenCV YAML (Q, or P1 and P2), or the keys focal_px, baseline_m, cx, cy, doffs_px");
}

}  // namespace hexrelief
