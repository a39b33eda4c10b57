// The calibration of a rectified stereo camera, which turns disparities into depths, and that of two cameras
// before their pictures are rectified.
#pragma once

#include <array>
#include <vector>

namespace hexrelief {

// Z = focal_px * baseline_m / (disparity + doffs_px). Image coordinates: x to the right, y down, from the
// image's top left corner, so that the centre of the top left pixel is (0.5, 0.5); the principal point (cx,
// cy) is in these coordinates. `metric` is false if nothing was calibrated: shapes are then right only up
// to scale and perspective.
struct Calibration {
    double focal_px = 0;
    double cx = 0;
    double cy = 0;
    double baseline_m = 0;
    double doffs_px = 0;
    bool metric = false;
    int width = 0;  // size of the image that the calibration was made for; 0 = unknown
    int height = 0;
    int ndisp_px = 0;  // all disparities of the scene are below this; 0 = unknown
};

// The calibration of two cameras before their pictures are rectified. The conventions are those of OpenCV's
// calibration functions: the centre of pixel 0 is at 0, and a point x in the left camera's coordinates is
// R x + T in the right camera's.
struct StereoCalibration {
    struct Camera {
        std::array<double, 9> matrix{};  // K, row-major
        std::vector<double> distortion;  // 0, 4, 5, 8, 12 or 14 coefficients; a fisheye lens has 4
    };

    Camera left, right;
    std::array<double, 9> rotation{};     // row-major
    std::array<double, 3> translation{};  // m
    bool is_fisheye = false;
    int width = 0, height = 0;  // size of the pictures; 0 = unknown
};

}  // namespace hexrelief
