// Reads the calibrations of cameras and of rectified pairs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pipeline/data/calibration.h"

namespace hexrelief::readers {

struct CalibrationSource {
    // One file, named by anything that is a path.
    template <typename Path>
    requires std::is_convertible_v<const Path&, std::filesystem::path> CalibrationSource(const Path& path)
        : file(path) {}  // NOLINT(google-explicit-constructor)
    CalibrationSource(std::filesystem::path path, std::filesystem::path second_path, int picture_width,
                      int picture_height, std::vector<std::filesystem::path> map_and_picture = {})
        : file(std::move(path)),
          second(std::move(second_path)),
          width(picture_width),
          height(picture_height),
          views(std::move(map_and_picture)) {}

    std::filesystem::path file;
    // The right camera's file, or that of the movement between the cameras; empty = none, or
    // find_other_file().
    std::filesystem::path second;
    int width = 0, height = 0;                 // of the pictures; 0 = not known
    std::vector<std::filesystem::path> views;  // by whose names the camera is found in a list
};

// Returns the file that goes with this one by its name and is there: right.yaml with left.yaml, cam1 with
// cam0, extrinsics.yml with intrinsics.yml, in the file's name or its folder's. Empty if there is none.
std::filesystem::path find_other_file(const std::filesystem::path& file);

struct CalibrationFile {
    Calibration calibration;
    std::string format;             // "Middlebury", "KITTI", ...
    std::vector<std::string> told;  // assumptions that may be wrong, a sentence each
    std::filesystem::path other;    // the second file that was read; empty = none
    double depth_per_m = 0;         // integers of the file's depth maps in a metre; 0 = not said
};

// Reads the calibration of a rectified pair or of one view, whose format is recognised by its content;
// exporters/FORMATS.md lists all formats, as key_table.cpp has them.
//
// The baseline of one view is 0, and metric then false. Principal points are moved from the format's own
// coordinate of the first pixel's centre (README.md) to that of Calibration. Missing width and height are 0
// (unknown). cx and cy are NaN if neither they nor a size is given, which means the middle of the picture.
// Focal lengths that differ by up to 1 % are replaced by their mean, which is told. Throws Error(input)
// naming file and key if something is missing, given twice, not a finite number, or impossible (focal length
// or baseline <= 0, pixels not square, a vertical pair, a model with distortion).
CalibrationFile read_calibration_file(const CalibrationSource& source);

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
