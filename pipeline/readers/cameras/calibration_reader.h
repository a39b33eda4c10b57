// Reads the calibrations of cameras and of rectified pairs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/calibration.h"

namespace hexrelief::readers {

struct CalibrationFile {
    Calibration calibration;
    std::string format;             // "Middlebury", "KITTI", ...
    std::vector<std::string> told;  // assumptions that may be wrong, a sentence each
};

// Reads a calibration file, whose format is recognised by its content.
//
// Formats of rectified pairs:
// - Middlebury's calib.txt: cam0, baseline in mm, doffs (or cam1, of which doffs is cam1 - cam0), width,
//   height. Stray spaces, CR LF, comments (#) and unknown keys are allowed.
// - KITTI: lines P0..P3 or P_rect_00..03 with 12 numbers, which give focal length, principal point and
//   baseline. The colour pair 2, 3 is preferred to 0, 1; the size is that of S_rect if given.
// - OpenCV's FileStorage YAML: Q, else P1 and P2. Lengths are taken as metres; the size is image_width and
//   image_height, or image_size, if given.
// - FoundationStereo's: the nine numbers of K, then the baseline in metres.
//
// Formats of a pair or of one camera:
// - ROS camera_info as YAML, by camera_calibration or by `rostopic echo`: P, else K. For a right camera, P's
//   fourth number is -fx times the baseline, and its principal point is used as the left one's.
// - hexrelief's own keys as YAML: focal_px, baseline_m, cx, cy, doffs_px, width, height. doffs_px is 0 if
//   left out; cx and cy may be left out together and are then the centre.
//
// Formats of one camera, whose baseline_m is then 0 and metric false:
// - a 3x3 camera matrix: nine numbers, with brackets or without, in an NPY file, or under the key
//   K, camera_matrix, intrinsic_matrix or intrinsics of a JSON or YAML file; by rows, or by columns
//   as in Open3D's PinholeCameraIntrinsic.
// - RealSense's intrinsics as JSON, and the like: fx, fy, ppx (or cx), ppy (or cy), width, height.
// - COLMAP's cameras.txt with one camera, SIMPLE_PINHOLE or PINHOLE.
//
// COLMAP and hexrelief's own keys count the centre of pixel 0 as 0.5, as Calibration does; all other formats
// count it as 0, so their principal points are moved by +0.5. Missing width and height are 0 (unknown). cx
// and cy are NaN if neither they nor a size is given, which means the middle of the picture. Focal lengths
// that differ by up to 1 % are replaced by their mean, which is told. Throws Error(input) naming file and key
// if something is missing, given twice, not a finite number, or impossible (focal length or baseline <= 0,
// pixels not square, a vertical pair, a model with distortion).
CalibrationFile read_calibration_file(const std::filesystem::path& path);

// Returns only the calibration of read_calibration_file().
Calibration read_calibration(const std::filesystem::path& path);

}  // namespace hexrelief::readers
