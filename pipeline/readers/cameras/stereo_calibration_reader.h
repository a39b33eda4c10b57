// Reads the calibrations of pairs that are not rectified.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/data/stereo_calibration.h"
#include "pipeline/readers/cameras/calibration_reader.h"

namespace hexrelief::readers {

// Whether a pair is rectified by the calibration of its cameras. automatic: yes, unless the file describes
// rectified pictures as well (Q, or P1 and P2) and the rows of the pair are the same already.
enum class Rectify { automatic, always, never };

struct StereoCalibrationFile {
    StereoCalibration calibration;
    std::string format;             // "OpenCV", "Kalibr", ...
    std::vector<std::string> told;  // assumptions that may be wrong, a sentence each
    bool is_rectified = false;      // the file tells of rectified pictures as well
    std::filesystem::path other;    // the second file that was read; empty = none
};

// Reads the cameras of a pair as it was taken: the matrices, the distortions, and the movement between the
// cameras; exporters/FORMATS.md lists the formats that have them. Four distortion coefficients are those of
// cv::fisheye if a key says so (fisheye, equidistant, kannala_brandt), or if no key names a model; the latter
// is told. Returns nullopt if the file tells of no second camera, if `rectify` is never, or if it is
// automatic and the file, which tells of rectified pictures, lacks a part of the others. Throws Error(input)
// naming file and key if a part is missing or wrong.
std::optional<StereoCalibrationFile> read_stereo_calibration(const CalibrationSource& source,
                                                             Rectify rectify);

}  // namespace hexrelief::readers
