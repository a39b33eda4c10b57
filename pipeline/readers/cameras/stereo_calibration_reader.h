// Reads calibrations of pairs whose pictures are not rectified.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/data/stereo_calibration.h"

namespace hexrelief::readers {

// Whether a pair is rectified with what its calibration file says of the cameras as they stand.
// automatic: where the file says nothing of rectified pictures (Q, or P1 and P2).
enum class Rectify { automatic, always, never };

struct StereoCalibrationFile {
    StereoCalibration calibration;
    std::vector<std::string> told;  // what was believed and may be wrong, a sentence each
};

// OpenCV's FileStorage YAML with K1, D1, K2, D2, R and T, T in metres; the matrices may be named M1 or
// cameraMatrix1, the distortions distCoeffs1. A key model, camera_model or distortion_model that says
// fisheye, equidistant or kannala_brandt makes 4 numbers of distortion cv::fisheye's, and so do 4 numbers
// where no model is said, which is told. nullopt where the file has none of these keys, or where `rectify` is
// no, or automatic and the file tells of rectified pictures. Throws Error(input) naming file and key where
// one is missing or wrong.
std::optional<StereoCalibrationFile> read_stereo_calibration(const std::filesystem::path& path,
                                                             Rectify rectify);

}  // namespace hexrelief::readers
