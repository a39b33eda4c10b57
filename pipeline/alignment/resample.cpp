#include "pipeline/alignment/resample.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "pipeline/base/opencv_squares.h"
#include "pipeline/base/opencv_threads.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/start_work.h"

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

constexpr int kBand = 32;       // rows resampled at a time
constexpr int kExactEvery = 8;  // columns: positions between are linear, which errs by some 1/500 px
constexpr int kBorder = 2;      // px at the border of what is seen, whose colours come from outside, too

// Positions in the picture as given of all pixels of a view; the centre of the first pixel is at (0, 0).
class Positions {
  public:
    Positions(const View& view, const Alignment& alignment, int view_x, double scale)
        : view_(view),
          canvas_(alignment.canvas),
          view_x_(view_x),
          is_turned_(alignment.estimate.is_quarter_turned),
          turned_height_(scale * alignment.estimate.camera.height) {}

    void fill_row(int y, float* x_out, float* y_out) const {
        Point from = at(0, y);
        for (int first = 0; first < canvas_.width; first += kExactEvery) {
            const Point to = at(first + kExactEvery, y);
            const double step_x = (to.x - from.x) / kExactEvery, step_y = (to.y - from.y) / kExactEvery;
            const int count = std::min(kExactEvery, canvas_.width - first);
            for (int i = 0; i < count; ++i) {
                x_out[first + i] = static_cast<float>(from.x + step_x * i);
                y_out[first + i] = static_cast<float>(from.y + step_y * i);
            }
            from = to;
        }
    }

  private:
    Point at(int x, int y) const {
        const Point p = view_.in_picture({view_x_ + x + 0.5, canvas_.y + y + 0.5});
        return is_turned_ ? Point{turned_height_ - 1 - p.y, p.x} : p;
    }

    const View& view_;
    const Canvas& canvas_;
    int view_x_;
    bool is_turned_;
    double turned_height_;
};

struct Resampled {
    Image image;
    std::vector<std::uint8_t> known;  // 1 = inside the picture as given
};

cv::Mat matrix_of(const Image& image) {
    return {image.height, image.width, CV_8UC(image.channels),
            const_cast<std::uint8_t*>(image.pixels.data())};
}

// has_image: false leaves the image empty.
Resampled room_on(const Canvas& canvas, int channels, bool has_image = true) {
    const std::size_t area = static_cast<std::size_t>(canvas.width) * canvas.height;
    Resampled out{{canvas.width, canvas.height, channels, {}}, std::vector<std::uint8_t>(area)};
    if (has_image)
        out.image.pixels.resize(area * channels);
    else
        out.image.width = out.image.height = 0;
    return out;
}

// out: from room_on().
Resampled resampled(const Image& image, const Positions& positions, const Canvas& canvas, int interpolation,
                    ThreadPool& pool, Resampled out) {
    const bool has_image = !out.image.empty();
    const cv::Mat from = matrix_of(image), to = matrix_of(out.image);
    const float most_x = static_cast<float>(image.width - 1), most_y = static_cast<float>(image.height - 1);
    const int bands = (canvas.height + kBand - 1) / kBand;
    const OpenCvThreads one(1);  // the pool's threads share the work
    pool.parallel_for(static_cast<std::size_t>(bands), [&](std::size_t first_band, std::size_t last_band) {
        cv::Mat x(kBand, canvas.width, CV_32FC1), y(kBand, canvas.width, CV_32FC1);
        for (int band = static_cast<int>(first_band); band < static_cast<int>(last_band); ++band) {
            const int first = band * kBand, rows = std::min(kBand, canvas.height - first);
            for (int i = 0; i < rows; ++i) {
                float *const row_x = x.ptr<float>(i), *const row_y = y.ptr<float>(i);
                positions.fill_row(first + i, row_x, row_y);
                std::uint8_t* const known = &out.known[static_cast<std::size_t>(first + i) * canvas.width];
                for (int c = 0; c < canvas.width; ++c)
                    known[c] = row_x[c] >= 0 && row_y[c] >= 0 && row_x[c] <= most_x && row_y[c] <= most_y;
            }
            if (!has_image) continue;
            cv::Mat part = to.rowRange(first, first + rows);
            cv::remap(from, part, x.rowRange(0, rows), y.rowRange(0, rows), interpolation,
                      cv::BORDER_REPLICATE);
        }
    });
    return out;
}

// Returns noise between 0 and 255, by a hash of the place.
std::uint8_t noise_at(int x, int y) {
    std::uint32_t v =
        static_cast<std::uint32_t>(x) * 2654435761u + static_cast<std::uint32_t>(y) * 2246822519u;
    v ^= v >> 15;
    v *= 2654435761u;
    v ^= v >> 13;
    return static_cast<std::uint8_t>(v);
}

void fill_unknown(Resampled& view, ThreadPool& pool) {
    Image& image = view.image;
    pool.parallel_for_each(image.height, [&](int y) {
        for (int x = 0; x < image.width; ++x)
            if (!view.known[static_cast<std::size_t>(y) * image.width + x])
                std::fill_n(image.at(x, y), image.channels, noise_at(x, y));
    });
}

// Sets to 0 the left pixels that the right view cannot show at disparities from 0 to `largest`.
void drop_unseen(std::vector<std::uint8_t>& left, const std::vector<std::uint8_t>& right, int width,
                 int largest, ThreadPool& pool) {
    const auto row_size = static_cast<std::size_t>(width);
    pool.parallel_for(left.size() / row_size, [&](std::size_t first, std::size_t last) {
        std::vector<int> before(row_size + 1);  // right pixels known left of a column
        for (std::size_t row = first * row_size; row < last * row_size; row += row_size) {
            for (int x = 0; x < width; ++x) before[x + 1] = before[x] + right[row + x];
            for (int x = 0; x < width; ++x)
                if (before[x + 1] == before[std::max(0, x - largest)]) left[row + x] = 0;
        }
    });
}

// Returns the disparity up to which a left pixel has to be seen by the right view: that of the nearest
// things, or, if the strip that shows only near things is narrow, nearly that of the farthest ones. In that
// strip bare sky or wall would match as if it were near.
double reach_of(const DisparityBounds& bounds, int width) {
    constexpr double kNarrow = 0.05, kFar = 0.25, kBeyond = 0.1;  // of the width; of the spread
    const double spread = bounds.largest_px - bounds.least_px;
    return spread < kNarrow * width ? bounds.least_px + kFar * spread : bounds.largest_px + kBeyond * spread;
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

AlignedPair aligned_pair(const StereoPair& pair, const Alignment& alignment, int threads, bool has_right) {
    ThreadPool pool(threads);
    const Estimate& estimate = alignment.estimate;
    const Canvas& canvas = alignment.canvas;
    const double scale =
        std::max(pair.left.width, pair.left.height) / std::max(estimate.camera.width, estimate.camera.height);
    const Views views = estimate.views(scale);
    const Image& first = estimate.is_exchanged ? pair.right : pair.left;
    const Image& second = estimate.is_exchanged ? pair.left : pair.right;
    const Positions in_left(views.left, alignment, canvas.left_x, scale),
        in_right(views.right, alignment, canvas.right_x, scale);
    auto right_room = start_work(threads, [&] { return room_on(canvas, second.channels, has_right); });
    Resampled left =
        resampled(first, in_left, canvas, cv::INTER_CUBIC, pool, room_on(canvas, first.channels));
    Resampled right = resampled(second, in_right, canvas, cv::INTER_CUBIC, pool, right_room.get());
    if (!first.alpha.empty()) {
        const Image alpha{first.width, first.height, 1, first.alpha};
        left.image.alpha =
            resampled(alpha, in_left, canvas, cv::INTER_NEAREST, pool, room_on(canvas, 1)).image.pixels;
    }
    fill_unknown(right, pool);
    drop_unseen(left.known, right.known, canvas.width,
                static_cast<int>(reach_of(alignment.disparities, canvas.width)) + kBorder, pool);
    take_least(left.known, canvas.width, canvas.height, kBorder);
    take_least(right.known, canvas.width, canvas.height, kBorder);
    return {{std::move(left.image), std::move(right.image)}, std::move(left.known), std::move(right.known)};
}

std::array<double, 2> up_of(const Alignment& alignment) {
    const Estimate& estimate = alignment.estimate;
    const Camera& camera = estimate.camera;
    const View left = estimate.views().left;
    const Point middle{camera.width / 2, camera.height / 2};
    const Point above =
        estimate.is_quarter_turned ? Point{middle.x - 1, middle.y} : Point{middle.x, middle.y - 1};
    const Point from = left.rectified(middle), to = left.rectified(above);
    const double x = to.x - from.x, y = from.y - to.y, length = std::sqrt(x * x + y * y);
    return {x / length, y / length};
}

Calibration camera_of(const Alignment& alignment) {
    return {.focal_px = alignment.focal_px,
            .cx = static_cast<double>(-alignment.canvas.left_x),
            .cy = static_cast<double>(-alignment.canvas.y),
            .doffs_px = -alignment.disparities.infinity_px,
            .width = alignment.canvas.width,
            .height = alignment.canvas.height};
}

}  // namespace hexrelief::alignment
