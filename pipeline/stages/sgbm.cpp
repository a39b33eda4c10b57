#include "pipeline/stages/sgbm.h"

#include <algorithm>
#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "pipeline/base/opencv_threads.h"
#include "pipeline/data/error.h"

namespace hexrelief::stages {
namespace {

constexpr int kStep = 16;  // StereoSGBM needs multiples of this

struct Range {
    int min_px = 0;
    int count_px = 0;
};

cv::Mat wrap(const Image& image) {  // OpenCV wants non-const data; nothing here writes to it
    return cv::Mat(image.height, image.width, CV_8UC(image.channels),
                   const_cast<std::uint8_t*>(image.pixels.data()));
}

cv::Mat grey(const cv::Mat& image) {
    if (image.channels() == 1) return image;
    cv::Mat result;
    cv::cvtColor(image, result, cv::COLOR_RGB2GRAY);
    return result;
}

int matcher_mode(SgbmMode mode) {
    switch (mode) {
        case SgbmMode::sgbm:
            return cv::StereoSGBM::MODE_SGBM;
        case SgbmMode::hh:
            return cv::StereoSGBM::MODE_HH;
        case SgbmMode::sgbm_3way:
            return cv::StereoSGBM::MODE_SGBM_3WAY;
        case SgbmMode::hh4:
            return cv::StereoSGBM::MODE_HH4;
    }
    return cv::StereoSGBM::MODE_SGBM_3WAY;
}

// Returns the disparities of `base`, matched against `other`. SGBM gives nothing for columns whose
// search range leaves the image (the left band, as wide as the range), so both images are widened there
// and the result is cropped.
cv::Mat match_view(const cv::Mat& base, const cv::Mat& other, const Range& range,
                   const DisparityConfig& config) {
    const int left = std::max(0, range.min_px + range.count_px), right = std::max(0, -range.min_px);
    cv::Mat wide_base, wide_other, wide;
    cv::copyMakeBorder(base, wide_base, 0, 0, left, right, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(other, wide_other, 0, 0, left, right, cv::BORDER_REPLICATE);
    const int area = base.channels() * config.block_size_px * config.block_size_px;
    const int p2 = config.p2 > 0 ? config.p2 : std::min(64 * area, kLargestPenalty);
    const int p1 = config.p1 > 0 ? config.p1 : std::min(16 * area, kLargestPenalty / 4);
    // The built-in left-right check guesses the right view from the left one's costs, so it is switched off
    // by a limit that no difference reaches (0 and less mean 1). Speckles are removed after the real check.
    const auto matcher = cv::StereoSGBM::create(
        range.min_px, range.count_px, config.block_size_px, p1, p2, 1 << 14, config.pre_filter_cap,
        config.uniqueness_ratio_percent, 0, 0, matcher_mode(config.mode));
    matcher->compute(wide_base, wide_other, wide);
    cv::Mat result = wide.colRange(left, left + base.cols).clone();
    result.setTo(kUnmatched, result < range.min_px * kRawScale);
    return result;
}

RawDisparities to_raw(const cv::Mat& view) {
    const auto* const first = view.ptr<std::int16_t>();
    return {view.cols, view.rows, std::vector<std::int16_t>(first, first + view.total())};
}

RawDisparities match_left(const cv::Mat& left, const cv::Mat& right, const Range& range,
                          const DisparityConfig& config) {
    return to_raw(match_view(left, right, range, config));
}

// Matches the right view as the left view of the mirrored pair.
RawDisparities match_right(const cv::Mat& left, const cv::Mat& right, const Range& range,
                           const DisparityConfig& config) {
    cv::Mat mirrored_left, mirrored_right, result;
    cv::flip(left, mirrored_left, 1);
    cv::flip(right, mirrored_right, 1);
    cv::flip(match_view(mirrored_right, mirrored_left, range, config), result, 1);
    return to_raw(result);
}

// Calls work(), turning OpenCV's exceptions into errors of this program. If the system gives OpenCV's thread
// library no thread, work() is called again with one thread.
template <typename Work>
auto with_opencv(int threads, const Work& work) -> decltype(work()) {
    try {
        const OpenCvThreads guard(threads);
        return work();
    } catch (const cv::Exception& error) {
        const bool memory = error.code == cv::Error::StsNoMem;
        throw Error(
            memory ? ErrorKind::usage : ErrorKind::input,
            "disparity: " + error.err + (memory ? "; use disparity.mode sgbm_3way or a narrower range" : ""));
    } catch (const Error&) {
        throw;
    } catch (const std::runtime_error&) {
        if (threads == 1) throw;
        return with_opencv(1, work);
    }
}

}  // namespace

int round_up_range(int disparities) {
    return (disparities + kStep - 1) / kStep * kStep;
}

RawViews match_views_sgbm(const StereoPair& pair, const DisparityConfig& config, int threads) {
    return with_opencv(threads, [&] {
        cv::Mat left = wrap(pair.left), right = wrap(pair.right);
        if (!config.color || left.channels() != right.channels()) {
            left = grey(left);
            right = grey(right);
        }
        const Range range{config.min_disparity_px, config.num_disparities_px};
        return RawViews{match_left(left, right, range, config), match_right(left, right, range, config)};
    });
}

void remove_speckles(RawDisparities& map, int window_px, int range_px) {
    if (window_px <= 0) return;
    cv::Mat view(map.height, map.width, CV_16SC1, map.values.data());
    cv::filterSpeckles(view, kUnmatched, window_px, range_px * kRawScale);
}

}  // namespace hexrelief::stages
