// The library that disparity.wls loads; the only file that uses OpenCV's ximgproc.
#include <cstdio>
#include <exception>
#include <opencv2/core.hpp>
#include <opencv2/ximgproc/disparity_filter.hpp>

#include "pipeline/stages/wls_filter.h"

extern "C" __attribute__((visibility("default"))) int hexrelief_wls_filter(
    const hexrelief::stages::WlsRequest* request) {
    try {
        const hexrelief::stages::WlsRequest& r = *request;
        // OpenCV wants non-const data; nothing below writes to it.
        const auto wrap = [&](const void* data, int type) {
            return cv::Mat(r.height, r.width, type, const_cast<void*>(data));
        };
        const auto filter = cv::ximgproc::createDisparityWLSFilterGeneric(true);
        filter->setLambda(r.lambda);
        filter->setSigmaColor(r.sigma);
        filter->setDepthDiscontinuityRadius(r.discontinuity_radius_px);
        cv::Mat filtered(r.height, r.width, CV_16SC1, r.filtered);
        cv::Mat result;
        filter->filter(wrap(r.left, CV_16SC1), wrap(r.guide, CV_MAKETYPE(CV_8U, r.channels)), result,
                       wrap(r.right, CV_16SC1), cv::Rect(0, 0, r.width, r.height));
        result.convertTo(filtered, CV_16SC1);
        return 0;
    } catch (const std::exception& error) {
        std::snprintf(request->message, static_cast<std::size_t>(request->message_bytes), "%s", error.what());
        return 1;
    }
}
