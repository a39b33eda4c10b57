#include "pipeline/readers/cameras/calibration_reader.h"

#include <cmath>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/cameras/camera_file.h"
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

CalibrationFile read_calibration_file(const CalibrationSource& source) {
    codec::CameraFile file(source, false);
    Calibration calibration = file.parts ? file.parts->rectified() : *file.calibration;
    calibration.metric = file.text.has_baseline;
    check_possible(file.text, calibration);
    return {calibration, file.text.format, file.text.told, file.other,
            file.parts ? file.parts->depth_per_m() : 0};
}

Calibration read_calibration(const CalibrationSource& source) {
    return read_calibration_file(source).calibration;
}

std::optional<StereoCalibrationFile> read_stereo_calibration(const CalibrationSource& source,
                                                             Rectify rectify) {
    if (rectify == Rectify::never) return std::nullopt;
    codec::CameraFile file(source, true);
    const bool has_pair = file.parts && file.parts->has_pair();
    const bool is_rectified = file.parts && file.parts->is_rectified();
    if (rectify == Rectify::automatic && (!has_pair || (is_rectified && !file.parts->has_movement())))
        return std::nullopt;
    if (!has_pair)
        codec::refuse_key(file.text, "K1, D1, K2, D2, R and T", "must be there to rectify the pair");
    StereoCalibration pair = file.parts->pair();
    return StereoCalibrationFile{std::move(pair), file.text.format, file.text.told, is_rectified, file.other};
}

}  // namespace hexrelief::readers
