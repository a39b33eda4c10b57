// Tests pairs of bright spots, projected by the camera models' formulas from OpenCV's documentation.
#include "pipeline/alignment/rectify/rectify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/expect_error.h"

namespace hexrelief::alignment {
namespace {

constexpr int kWidth = 320, kHeight = 240, kColumns = 5, kRows = 4;

struct Point {
    double x = 0, y = 0, z = 0;
};

double distance(const Point& a, const Point& b) {
    return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

// Returns a position in pixels; the centre of pixel 0 is at 0.
Point project(const StereoCalibration::Camera& camera, bool is_fisheye, const Point& p) {
    const double x = p.x / p.z, y = p.y / p.z, r2 = x * x + y * y;
    const std::vector<double>& d = camera.distortion;
    double u = 0, v = 0;
    if (is_fisheye) {
        const double r = std::sqrt(r2), t = std::atan(r), t2 = t * t;
        const double scale = r > 0 ? t * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3])))) / r : 1;
        u = x * scale;
        v = y * scale;
    } else {
        const double radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
        u = x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x);
        v = y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y;
    }
    const auto& k = camera.matrix;
    return {k[0] * u + k[2], k[4] * v + k[5], 1};
}

Point in_right_camera(const StereoCalibration& c, const Point& p) {
    const auto& r = c.rotation;
    return {r[0] * p.x + r[1] * p.y + r[2] * p.z + c.translation[0],
            r[3] * p.x + r[4] * p.y + r[5] * p.z + c.translation[1],
            r[6] * p.x + r[7] * p.y + r[8] * p.z + c.translation[2]};
}

// Returns a grid of points between 2 and 3 m away, row after row.
std::vector<Point> scene() {
    std::vector<Point> points;
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) {
            const double z = 2 + 0.25 * ((row * 3 + column * 2) % 5);
            points.push_back({(column - 2) * 0.2 * z, (row - 1.5) * 0.2 * z, z});
        }
    return points;
}

Image picture_of(const std::vector<Point>& spots) {
    Image image{kWidth, kHeight, 1, std::vector<std::uint8_t>(static_cast<std::size_t>(kWidth) * kHeight)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            double sum = 0;
            for (const Point& spot : spots) sum += std::exp(-std::hypot(x - spot.x, y - spot.y) / 2);
            image.at(x, y)[0] = static_cast<std::uint8_t>(std::lround(std::min(1.0, sum) * 255));
        }
    return image;
}

StereoPair pair_of(const StereoCalibration& c) {
    std::vector<Point> left, right;
    for (const Point& p : scene()) {
        left.push_back(project(c.left, c.is_fisheye, p));
        right.push_back(project(c.right, c.is_fisheye, in_right_camera(c, p)));
    }
    return {picture_of(left), picture_of(right)};
}

// Returns the centre of the light around a pixel, in Image's coordinates.
Point centre_of(const Image& image, int peak_x, int peak_y) {
    constexpr int reach = 9;
    Point at{peak_x + 0.5, peak_y + 0.5, 0};
    for (int round = 0; round < 6; ++round) {
        double weight = 0, x_sum = 0, y_sum = 0;
        for (int y = std::max(0, peak_y - reach - 2); y < std::min(kHeight, peak_y + reach + 3); ++y)
            for (int x = std::max(0, peak_x - reach - 2); x < std::min(kWidth, peak_x + reach + 3); ++x) {
                const double far = std::hypot(x + 0.5 - at.x, y + 0.5 - at.y);
                const double light = image.at(x, y)[0] * std::max(0.0, 1 - far / reach);
                weight += light;
                x_sum += light * (x + 0.5);
                y_sum += light * (y + 0.5);
            }
        at = {x_sum / weight, y_sum / weight, 0};
    }
    return at;
}

// Returns the spots row after row, from left to right.
std::vector<Point> spots_of(const Image& image) {
    std::vector<Point> spots;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const auto is_near = [&](const Point& p) { return std::hypot(p.x - x, p.y - y) < 9; };
            if (image.at(x, y)[0] < 110 || std::any_of(spots.begin(), spots.end(), is_near)) continue;
            spots.push_back(centre_of(image, x, y));
        }
    std::sort(spots.begin(), spots.end(), [](const Point& a, const Point& b) { return a.y < b.y; });
    for (std::size_t i = 0; i + kColumns <= spots.size(); i += kColumns)
        std::sort(spots.begin() + i, spots.begin() + i + kColumns,
                  [](const Point& a, const Point& b) { return a.x < b.x; });
    return spots;
}

std::array<double, 9> rotation(double about_x, double about_y, double about_z) {
    const double a = std::cos(about_x), b = std::sin(about_x), c = std::cos(about_y), d = std::sin(about_y),
                 e = std::cos(about_z), f = std::sin(about_z);
    return {
        c * e, -c * f, d, a * f + b * d * e, a * e - b * d * f, -b * c, b * f - a * d * e, b * e + a * d * f,
        a * c};
}

StereoCalibration pinhole_cameras() {
    return {.left = {{262, 0, 161, 0, 260, 118, 0, 0, 1}, {-0.12, 0.05, 0.001, -0.002, 0.01}},
            .right = {{258, 0, 157, 0, 259, 122, 0, 0, 1}, {-0.1, 0.03, -0.001, 0.001, 0}},
            .rotation = rotation(0.02, -0.03, 0.025),
            .translation = {-0.15, 0.006, 0.004}};
}

StereoCalibration fisheye_cameras() {
    StereoCalibration c = pinhole_cameras();
    c.left.distortion = {-0.02, 0.005, -0.002, 0.001};
    c.right.distortion = {-0.015, 0.004, 0, 0};
    c.is_fisheye = true;
    return c;
}

class Rectified : public testing::TestWithParam<bool> {};

TEST_P(Rectified, RowsCoincideAndDistancesAreRight) {
    const StereoCalibration cameras = GetParam() ? fisheye_cameras() : pinhole_cameras();
    const StereoPair taken = pair_of(cameras);
    const auto [pair, camera, seen] = rectify(taken, cameras, 1);
    EXPECT_EQ(seen.size(), pair.left.pixels.size());
    const std::vector<Point> left = spots_of(pair.left), right = spots_of(pair.right), truth = scene();
    ASSERT_EQ(left.size(), truth.size());
    ASSERT_EQ(right.size(), truth.size());
    EXPECT_EQ(camera.doffs_px, 0);
    EXPECT_NEAR(camera.baseline_m, std::hypot(0.15, 0.006, 0.004), 1e-9);

    double worst_row = 0, worst_before = 0;
    std::vector<Point> found;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        worst_row = std::max(worst_row, std::abs(left[i].y - right[i].y));
        const double z = camera.focal_px * camera.baseline_m / (left[i].x - right[i].x);
        found.push_back({(left[i].x - camera.cx) / camera.focal_px * z,
                         (left[i].y - camera.cy) / camera.focal_px * z, z});
        const Point a = project(cameras.left, cameras.is_fisheye, truth[i]);
        const Point b = project(cameras.right, cameras.is_fisheye, in_right_camera(cameras, truth[i]));
        worst_before = std::max(worst_before, std::abs(a.y - b.y));
    }
    EXPECT_GT(worst_before, 3) << "the pair was rectified before";
    EXPECT_LT(worst_row, 0.1);
    // A rectified camera is rotated, so positions differ from the scene's by a rotation, but distances do
    // not. 0.1 px of disparity is 1.5 cm at 2.4 m.
    double worst = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        worst = std::max(worst, std::abs(distance(found[i], {}) - distance(truth[i], {})));
        for (std::size_t j = 0; j < i; ++j)
            worst = std::max(worst, std::abs(distance(found[i], found[j]) - distance(truth[i], truth[j])));
    }
    EXPECT_LT(worst, 0.015);
}

TEST_P(Rectified, SameBytesOnAnyNumberOfThreads) {
    const StereoCalibration cameras = GetParam() ? fisheye_cameras() : pinhole_cameras();
    const StereoPair taken = pair_of(cameras);
    const RectifiedPair one = rectify(taken, cameras, 1);
    for (const int threads : {2, 7}) {  // OpenCV starts no more threads than the machine has processors
        const RectifiedPair more = rectify(taken, cameras, threads);
        EXPECT_EQ(one.pair.left.pixels, more.pair.left.pixels);
        EXPECT_EQ(one.pair.right.pixels, more.pair.right.pixels);
        EXPECT_EQ(one.seen, more.seen);
        EXPECT_EQ(one.calibration.focal_px, more.calibration.focal_px);
    }
}

// In rectified white pictures only the pixels outside of them are black.
TEST_P(Rectified, WhatThePictureDoesNotShowIsNotSeen) {
    StereoCalibration cameras = GetParam() ? fisheye_cameras() : pinhole_cameras();
    cameras.rotation = rotation(0.2, -0.03, 0.2);
    StereoPair white = pair_of(cameras);
    std::fill(white.left.pixels.begin(), white.left.pixels.end(), 255);
    const auto [pair, camera, seen] = rectify(white, cameras, 1);
    ASSERT_EQ(seen.size(), pair.left.pixels.size());
    int hidden = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        EXPECT_TRUE(!seen[i] || pair.left.pixels[i] == 255);
        hidden += !seen[i];
    }
    EXPECT_GE(hidden, cameras.is_fisheye ? 1 : 0);
    EXPECT_LT(hidden, kWidth * kHeight / 4);
}

INSTANTIATE_TEST_SUITE_P(Models, Rectified, testing::Bool(),
                         [](const auto& one) { return one.param ? "Fisheye" : "Pinhole"; });

TEST(Rectify, CamerasThatAreNotSideBySideAreRefused) {
    const StereoPair taken = pair_of(pinhole_cameras());
    StereoCalibration above = pinhole_cameras(), swapped = pinhole_cameras(), wild = fisheye_cameras();
    above.translation = {0.001, -0.15, 0};
    EXPECT_THROW(rectify(taken, above, 1), Error);
    swapped.translation = {0.15, 0, 0};
    EXPECT_THROW(rectify(taken, swapped, 1), Error);
    wild.left.distortion = {1e9, -1e9, 1e9, -1e9};
    test::refusal_of([&] { rectify(taken, wild, 1); });
}

TEST(Rectify, SidesThatOpenCvCannotCountAreRefused) {
    const Image long_row{kLargestPairSide_px + 1, 1, 1,
                         std::vector<std::uint8_t>(std::size_t{kLargestPairSide_px} + 1)};
    EXPECT_THROW(rectify({long_row, long_row}, pinhole_cameras(), 1), Error);
}

}  // namespace
}  // namespace hexrelief::alignment
