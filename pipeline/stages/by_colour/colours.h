// Sums of pictures' colours over squares. For rooms that link OpenCV's imgproc.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/image.h"

namespace hexrelief::stages {

// Returns the sums of each channel over the square around each pixel, which reaches `radius` <= 5 pixels to
// each side; beyond the border the nearest pixel counts. CV_16S, of the image's size and channels.
inline cv::Mat colour_sums(const Image& image, int radius, ThreadPool& pool) {
    const int type = CV_8UC(image.channels), side = 2 * radius + 1;
    const cv::Mat colours(image.height, image.width, type,
                          const_cast<std::uint8_t*>(image.pixels.data()));  // nothing here writes to it
    cv::Mat sums(image.height, image.width, CV_16SC(image.channels));
    pool.parallel_for(static_cast<std::size_t>(image.height), [&](std::size_t first, std::size_t end) {
        const cv::Range rows(static_cast<int>(first), static_cast<int>(end));
        if (rows.empty()) return;
        cv::Mat out = sums.rowRange(rows);  // OpenCV reads the rows around as well
        cv::boxFilter(colours.rowRange(rows), out, CV_16S, {side, side}, {-1, -1}, false,
                      cv::BORDER_REPLICATE);
    });
    return sums;
}

// Returns the largest difference of two pixels' channels.
inline int most_difference(const cv::Mat& sums, std::size_t i, std::size_t j) {
    const auto channels = static_cast<std::size_t>(sums.channels());
    const std::int16_t *const a = sums.ptr<std::int16_t>() + i * channels, *const b =
                                                                               sums.ptr<std::int16_t>() +
                                                                               j * channels;
    int most = 0;
    for (std::size_t c = 0; c < channels; ++c) most = std::max(most, std::abs(a[c] - b[c]));
    return most;
}

}  // namespace hexrelief::stages
