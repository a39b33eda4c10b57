// Reads the calibrations of pairs that are not rectified.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/data/stereo_calibration.h"

namespace hexrelief::readers {

// Whether a pair is rectified by the calibration of its cameras. automatic: yes, unless the file describes
// rectified pictures (Q, or P1 and P2).
enum class Rectify { automatic, always, never };

struct StereoCalibrationFile {
    StereoCalibration calibration;
    std::vector<std::string> told;  // assumptions that may be wrong, a sentence each
};

// Reads OpenCV's FileStorage YAML with K1, D1, K2, D2, R and T; T is in metres. The matrices may also be
// named M1 or cameraMatrix1, the distortions distCoeffs1. Four distortion coefficients are those of
// cv::fisheye if a key model, camera_model or distortion_model says fisheye, equidistant or kannala_brandt,
// or if there is no such key; the latter is told. Returns nullopt if the file has none of these keys, if
// `rectify` is never, or if it is automatic and the file describes rectified pictures. Throws Error(input)
// naming file and key if one is missing or wrong.
std::optional<StereoCalibrationFile> read_stereo_calibration(const std::filesystem::path& path,
                                                             Rectify rectify);

}  // namespace hexrelief::readers
