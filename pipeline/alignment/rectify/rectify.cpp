#include "pipeline/alignment/rectify/rectify.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "pipeline/base/opencv_threads.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::alignment {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorKind::input, "cannot rectify the pair: " + what);
}

template <std::size_t Count>
cv::Mat matrix_of(const std::array<double, Count>& values, int columns) {
    return cv::Mat(static_cast<int>(Count) / columns, columns, CV_64F, const_cast<double*>(values.data()))
        .clone();
}

struct View {
    cv::Mat matrix, distortion;
    cv::Mat rotation, projection;  // of the rectified view
};

View view_of(const StereoCalibration::Camera& camera) {
    return {matrix_of(camera.matrix, 3), cv::Mat(camera.distortion, true), {}, {}};
}

void find_views(const StereoCalibration& calibration, cv::Size size, View& left, View& right) {
    const cv::Mat r = matrix_of(calibration.rotation, 3), t = matrix_of(calibration.translation, 1);
    cv::Mat q;
    if (calibration.is_fisheye)
        cv::fisheye::stereoRectify(left.matrix, left.distortion, right.matrix, right.distortion, size, r, t,
                                   left.rotation, right.rotation, left.projection, right.projection, q,
                                   cv::CALIB_ZERO_DISPARITY, size, 0, 1);
    else
        cv::stereoRectify(left.matrix, left.distortion, right.matrix, right.distortion, size, r, t,
                          left.rotation, right.rotation, left.projection, right.projection, q,
                          cv::CALIB_ZERO_DISPARITY, 0, size);
}

Calibration calibration_of(const cv::Mat& left, const cv::Mat& right, cv::Size size) {
    constexpr double pixel_centre = 0.5;  // OpenCV counts the centre of pixel 0 as 0
    Calibration camera{.focal_px = left.at<double>(0, 0),
                       .cx = left.at<double>(0, 2) + pixel_centre,
                       .cy = left.at<double>(1, 2) + pixel_centre,
                       .baseline_m = -right.at<double>(0, 3) / right.at<double>(0, 0),
                       .doffs_px = right.at<double>(0, 2) - left.at<double>(0, 2),
                       .metric = true,
                       .width = size.width,
                       .height = size.height};
    if (right.at<double>(1, 3) != 0)
        refuse("its cameras stand one above the other (T); side by side is needed");
    if (!(camera.focal_px > 0) || !std::isfinite(camera.focal_px) || !std::isfinite(camera.cx) ||
        !std::isfinite(camera.cy))
        refuse("no view is left of both cameras; check K1, D1, K2, D2, R and T");
    if (!(camera.baseline_m > 0))
        refuse(
            "by T the right camera stands left of the left one; swap the pictures, or the cameras' numbers");
    return camera;
}

// The position in the picture as taken of each pixel of the rectified one.
struct Positions {
    cv::Mat x, y;
};

Positions positions_of(const View& view, cv::Size size, bool is_fisheye) {
    Positions at;
    if (is_fisheye)
        cv::fisheye::initUndistortRectifyMap(view.matrix, view.distortion, view.rotation, view.projection,
                                             size, CV_32FC1, at.x, at.y);
    else
        cv::initUndistortRectifyMap(view.matrix, view.distortion, view.rotation, view.projection, size,
                                    CV_32FC1, at.x, at.y);
    return at;
}

std::vector<std::uint8_t> inside(const Positions& at, cv::Size size) {
    std::vector<std::uint8_t> seen;
    seen.reserve(static_cast<std::size_t>(size.area()));
    for (int row = 0; row < size.height; ++row)
        for (int column = 0; column < size.width; ++column) {
            const float x = at.x.at<float>(row, column), y = at.y.at<float>(row, column);
            seen.push_back(x >= 0 && y >= 0 && x <= static_cast<float>(size.width - 1) &&
                           y <= static_cast<float>(size.height - 1));
        }
    return seen;
}

Image remapped(const Image& image, const Positions& at) {
    const cv::Size size(image.width, image.height);
    Image out{image.width, image.height, image.channels, std::vector<std::uint8_t>(image.pixels.size())};
    const int type = CV_8UC(image.channels);
    const cv::Mat from(size, type, const_cast<std::uint8_t*>(image.pixels.data()));
    cv::Mat to(size, type, out.pixels.data());
    cv::remap(from, to, at.x, at.y, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    return out;
}

}  // namespace

RectifiedPair rectify(const StereoPair& pair, const StereoCalibration& calibration, int threads) {
    if (std::max(pair.left.width, pair.left.height) > kLargestPairSide_px)
        throw Error(ErrorKind::input, "the pictures are " + size_text(pair.left.width, pair.left.height) +
                                          "; to be rectified their sides may have up to " +
                                          std::to_string(kLargestPairSide_px) + " px: scale them down");
    const cv::Size size(pair.left.width, pair.left.height);
    try {
        const OpenCvThreads guard(threads);
        View left = view_of(calibration.left), right = view_of(calibration.right);
        find_views(calibration, size, left, right);
        RectifiedPair out;
        out.calibration = calibration_of(left.projection, right.projection, size);
        const Positions in_left = positions_of(left, size, calibration.is_fisheye);
        out.pair.left = remapped(pair.left, in_left);
        out.pair.right = remapped(pair.right, positions_of(right, size, calibration.is_fisheye));
        out.seen = inside(in_left, size);
        return out;
    } catch (const cv::Exception&) {
        refuse("OpenCV finds no view of both cameras; check K1, D1, K2, D2, R and T");
    } catch (const Error&) {
        throw;
    } catch (const std::runtime_error&) {  // the system gives OpenCV no thread: do all in the caller's
        if (threads == 1) throw;
        return rectify(pair, calibration, 1);
    }
}

}  // namespace hexrelief::alignment
