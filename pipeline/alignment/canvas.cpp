#include "pipeline/alignment/canvas.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::alignment {
namespace {

constexpr double kLargest = 1.6, kLeast = 0.2;  // of the pictures' sides
constexpr int kOutlineSteps = 20;
constexpr double kMargin = 0.02,
                 kMargin_px = 2;  // of the disparities' spread, and px of the matches' pictures

struct Interval {
    double low = 0, high = 0;

    void include(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
};

struct Box {
    Interval x, y;
};

// Returns the box around the picture's outline in the rectified view.
Box outline_of(const View& view, double width, double height) {
    const Point corner = view.rectified({0, 0});
    Box box{{corner.x, corner.x}, {corner.y, corner.y}};
    for (int i = 0; i <= kOutlineSteps; ++i) {
        const double x = (width - 1) * i / kOutlineSteps, y = (height - 1) * i / kOutlineSteps;
        for (const Point& at : {Point{x, 0}, Point{x, height - 1}, Point{0, y}, Point{width - 1, y}}) {
            const Point p = view.rectified(at);
            box.x.include(p.x);
            box.y.include(p.y);
        }
    }
    return box;
}

// Returns a part of the interval no longer than `most`, around 0 if it holds that.
Interval limited(const Interval& interval, double most) {
    if (interval.high - interval.low <= most) return interval;
    const double middle = std::clamp(0.0, interval.low + most / 2, interval.high - most / 2);
    return {middle - most / 2, middle + most / 2};
}

}  // namespace

Canvas canvas_of(const Estimate& estimate, const DisparityBounds& bounds, double scale) {
    const Camera camera = estimate.camera.scaled(1 / scale);
    const Views views = estimate.views(1 / scale);
    const Box left = outline_of(views.left, camera.width, camera.height),
              right = outline_of(views.right, camera.width, camera.height);
    const double margin = kMargin_px / scale + kMargin * (bounds.largest_px - bounds.least_px);
    const double shift = std::floor(bounds.least_px - margin);
    const Interval x = limited({std::max(left.x.low, right.x.low + shift),
                                std::min(left.x.high, right.x.high + bounds.largest_px + margin)},
                               kLargest * camera.width);
    const Interval y = limited({std::max(left.y.low, right.y.low), std::min(left.y.high, right.y.high)},
                               kLargest * camera.height);
    if (x.high - x.low < kLeast * camera.width || y.high - y.low < kLeast * camera.height) return {};
    const int left_x = static_cast<int>(std::floor(x.low));
    return {left_x, left_x - static_cast<int>(shift), static_cast<int>(std::floor(y.low)),
            static_cast<int>(x.high - x.low), static_cast<int>(y.high - y.low)};
}

DisparityBounds on_canvas(DisparityBounds bounds, const Canvas& canvas) {
    const int shift = canvas.left_x - canvas.right_x;
    bounds.least_px -= shift;
    bounds.largest_px -= shift;
    bounds.median_px -= shift;
    bounds.infinity_px -= shift;
    return bounds;
}

}  // namespace hexrelief::alignment
