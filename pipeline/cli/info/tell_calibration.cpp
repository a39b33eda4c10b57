#include "pipeline/cli/info/tell_calibration.h"

#include <cmath>
#include <utility>

#include "pipeline/data/error.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/cameras/stereo_calibration_reader.h"

namespace hexrelief::cli::info {
namespace {

void tell_calibration(const readers::CalibrationFile& file, Text& text) {
    const Calibration& camera = file.calibration;
    line(text, "format", "calibration, " + file.format);
    line(text, "focal", number(camera.focal_px) + " px", camera.focal_px);
    if (camera.baseline_m > 0)
        line(text, "baseline", number(camera.baseline_m) + " m", camera.baseline_m);
    else
        line(text, "baseline", "not known", nullptr);
    line(text, "centre",
         std::isnan(camera.cx) ? "not said: the middle"
                               : "(" + number(camera.cx) + ", " + number(camera.cy) +
                                     ") px, the first pixel's centre is (0.5, 0.5)",
         std::isnan(camera.cx) ? Json() : Json({camera.cx, camera.cy}));
    line(text, "doffs", number(camera.doffs_px) + " px", camera.doffs_px);
    if (camera.width > 0)
        line(text, "size", std::to_string(camera.width) + " x " + std::to_string(camera.height) + " px",
             size_json(camera.width, camera.height));
    if (file.depth_per_m > 0) line(text, "depths", number(file.depth_per_m) + " integers in a metre");
    if (!file.other.empty()) line(text, "also", file.other.string());
    lines(text, "note", file.told);
}

// Adds the calibration of two unrectified cameras.
void tell_stereo_calibration(const readers::StereoCalibrationFile& file, Text& text) {
    const StereoCalibration& cameras = file.calibration;
    line(text, "format",
         "calibration, " + file.format + ", of a pair to rectify" + (cameras.is_fisheye ? ", fisheye" : ""));
    for (const auto& [name, camera] : {std::pair{"left", cameras.left}, {"right", cameras.right}})
        line(text, name,
             "focal " + number(camera.matrix[0]) + " and " + number(camera.matrix[4]) + " px, " +
                 std::to_string(camera.distortion.size()) + " numbers of distortion");
    const auto& t = cameras.translation;
    const double baseline_m = std::hypot(t[0], t[1], t[2]);
    line(text, "baseline", number(baseline_m) + " m", baseline_m);
    if (cameras.width > 0)
        line(text, "size", std::to_string(cameras.width) + " x " + std::to_string(cameras.height) + " px",
             size_json(cameras.width, cameras.height));
    if (!file.other.empty()) line(text, "also", file.other.string());
    lines(text, "note", file.told);
}

}  // namespace

void tell_calibration_of(const std::filesystem::path& path, Text& text) {
    const auto stereo = readers::read_stereo_calibration(path, readers::Rectify::automatic);
    if (stereo && !stereo->is_rectified)
        tell_stereo_calibration(*stereo, text);
    else
        tell_calibration(readers::read_calibration_file(path), text);
}

bool tell_if_calibration(const std::filesystem::path& path, Text& text) {
    try {
        tell_calibration_of(path, text);
    } catch (const Error&) {
        return false;
    }
    return true;
}

}  // namespace hexrelief::cli::info
