#include "pipeline/readers/cameras/calibration_reader.h"

#include <cmath>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/cameras/calibration_formats.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers {
namespace {

// Refuses a focal length or baseline not above 0 and numbers that are not finite: later stages
// would divide by 0.
void check_possible(const codec::CalibrationText& source, const Calibration& calibration) {
    if (!(calibration.focal_px > 0) || !std::isfinite(calibration.focal_px)) {
        codec::refuse(source.path,
                      "the focal length is " + number_text(calibration.focal_px) + " px; it must be above 0");
    }
    if (source.has_baseline && (!(calibration.baseline_m > 0) || !std::isfinite(calibration.baseline_m))) {
        codec::refuse(source.path, "the baseline is " + number_text(calibration.baseline_m) +
                                       " m; it must be above 0 (left and right swapped?)");
    }
    const bool in_the_middle = std::isnan(calibration.cx) && std::isnan(calibration.cy);
    if (!(in_the_middle || (std::isfinite(calibration.cx) && std::isfinite(calibration.cy))) ||
        !std::isfinite(calibration.doffs_px)) {
        codec::refuse(source.path, "principal point and disparity offset must be finite numbers");
    }
}

}  // namespace

CalibrationFile read_calibration_file(const std::filesystem::path& path) {
    codec::CalibrationText source = codec::load_calibration_text(path);
    if (codec::trim(source.text).empty()) codec::refuse(path, "the file is empty; give a calibration");
    if (codec::trim(source.text).starts_with('<')) {
        codec::refuse(path, "XML is not supported; save OpenCV's calibration as .yml");
    }
    for (const auto parse : {codec::parse_middlebury, codec::parse_kitti, codec::parse_colmap,
                             codec::parse_matrix, codec::parse_yaml}) {
        if (auto calibration = parse(source)) {
            calibration->metric = source.has_baseline;
            check_possible(source, *calibration);
            return {*calibration, source.format, source.told};
        }
    }
    codec::refuse(
        path,
        "not a calibration that is known; give Middlebury's calib.txt (cam0=, baseline=), KITTI's (P2:, "
        "P3:), OpenCV YAML (Q, or P1 and P2), a 3x3 camera matrix, COLMAP's cameras.txt, ROS camera_info, "
        "Open3D's or RealSense's JSON, or the keys focal_px, baseline_m, cx, cy, doffs_px");
}

Calibration read_calibration(const std::filesystem::path& path) {
    return read_calibration_file(path).calibration;
}

}  // namespace hexrelief::readers
