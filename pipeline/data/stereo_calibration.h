// The calibration of two cameras before their pictures are rectified.
#pragma once

#include <array>
#include <vector>

namespace hexrelief {

// The conventions are those of OpenCV's calibration functions: the centre of pixel 0 is at 0, and a point x
// in the left camera's coordinates is R x + T in the right camera's.
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
