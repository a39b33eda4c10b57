// The largest and the least of squares of values. For rooms that link OpenCV's imgproc.
#pragma once

#include <opencv2/imgproc.hpp>
#include <vector>

namespace hexrelief {

// Replace each of width x height values by the largest one, or the least one, of the square around it, which
// reaches as far as `radius` values to each side.
template <typename Value>
void take_largest(std::vector<Value>& values, int width, int height, int radius) {
    const cv::Mat map(height, width, cv::DataType<Value>::type, values.data());
    cv::dilate(map, map, cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8UC1), {-1, -1}, 1,
               cv::BORDER_REPLICATE);
}
template <typename Value>
void take_least(std::vector<Value>& values, int width, int height, int radius) {
    const cv::Mat map(height, width, cv::DataType<Value>::type, values.data());
    cv::erode(map, map, cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8UC1), {-1, -1}, 1,
              cv::BORDER_REPLICATE);
}

}  // namespace hexrelief
