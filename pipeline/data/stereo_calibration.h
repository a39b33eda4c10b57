// Two cameras as they stand, before their pictures are rectified.
#pragma once

#include <array>
#include <vector>

namespace hexrelief {

// As OpenCV's calibration functions return them: the centre of pixel 0 is at 0, and a point x of the left
// camera is R x + T of the right one.
struct StereoCalibration {
    struct Camera {
        std::array<double, 9> matrix{};  // K, row-major
        std::vector<double> distortion;  // 0, 4, 5, 8, 12 or 14 numbers; of a fisheye 4
    };

    Camera left, right;
    std::array<double, 9> rotation{};     // row-major
    std::array<double, 3> translation{};  // m
    bool is_fisheye = false;
    int width = 0, height = 0;  // of the pictures, 0 = not said
};

}  // namespace hexrelief
