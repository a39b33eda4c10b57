#include "pipeline/alignment/second_look.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/alignment/canvas.h"
#include "pipeline/alignment/disparity_bounds.h"

namespace hexrelief::alignment {
namespace {

constexpr double kInside_px = 16;  // from the picture's border, beyond which a patch is not known
constexpr int kParts = 256;        // of a pixel, to which positions are rounded

// One of the aligned pictures, and where its points lie.
class AlignedPicture {
  public:
    AlignedPicture(const View& view, const Estimate& estimate, const Canvas& canvas, int x)
        : view_(view), estimate_(estimate), canvas_(canvas), x_(x) {}

    // Returns where the camera's picture, turned as the estimate's matches are, shows a pixel of the canvas.
    Point in_picture(const Point& on_canvas) const {
        return view_.in_picture({on_canvas.x + x_ + 0.5, on_canvas.y + canvas_.y + 0.5});
    }

    bool is_inside(const Point& p) const {
        const Camera& camera = estimate_.camera;
        return p.x >= kInside_px && p.y >= kInside_px && p.x < camera.width - kInside_px &&
               p.y < camera.height - kInside_px;
    }

    GreyPicture of(const GreyPicture& picture, ThreadPool& pool) const {
        GreyPicture out{canvas_.width, canvas_.height, {}};
        out.values.resize(static_cast<std::size_t>(out.width) * out.height);
        pool.parallel_for(static_cast<std::size_t>(out.height), [&](std::size_t first, std::size_t last) {
            for (std::size_t y = first; y < last; ++y)
                for (int x = 0; x < out.width; ++x)
                    out.row(static_cast<int>(y))[x] =
                        sample(picture, in_picture({1.0 * x, static_cast<double>(y)}));
        });
        return out;
    }

  private:
    // Returns the picture's linear interpolation; its border repeats outside.
    std::uint8_t sample(const GreyPicture& picture, Point p) const {
        const Camera& camera = estimate_.camera;
        if (estimate_.is_quarter_turned) p = {camera.height - 1 - p.y, p.x};
        const double width = estimate_.is_quarter_turned ? camera.height : camera.width,
                     height = estimate_.is_quarter_turned ? camera.width : camera.height;
        const auto place = [](double at, double side, int pixels) {
            const double scaled = (at + 0.5) * pixels / side - 0.5;
            return static_cast<int>(std::clamp(scaled, 0.0, pixels - 1.0) * kParts + 0.5);
        };
        const int x = place(p.x, width, picture.width), y = place(p.y, height, picture.height);
        const int column = x / kParts, row = y / kParts;
        const int next = std::min(column + 1, picture.width - 1);
        const std::uint8_t *const above = picture.row(row), *const below = picture.row(
                                                                std::min(row + 1, picture.height - 1));
        const int u = x % kParts, v = y % kParts;
        const int upper = above[column] * (kParts - u) + above[next] * u,
                  lower = below[column] * (kParts - u) + below[next] * u;
        return static_cast<std::uint8_t>((upper * (kParts - v) + lower * v + kParts * kParts / 2) /
                                         (kParts * kParts));
    }

    const View& view_;
    const Estimate& estimate_;
    const Canvas& canvas_;
    int x_;
};

}  // namespace

std::vector<Match> look_again(const Estimate& estimate, const GreyPicture& left, const GreyPicture& right,
                              ThreadPool& pool) {
    const Canvas canvas = canvas_of(estimate, bounds_of(estimate, false, 1), 1);
    if (canvas.width <= 0) return estimate.matches;
    const bool is_exchanged = estimate.is_exchanged;
    const Views views = estimate.views();
    const AlignedPicture first(views.left, estimate, canvas, canvas.left_x),
        second(views.right, estimate, canvas, canvas.right_x);
    std::vector<Match> found = find_matches(first.of(is_exchanged ? right : left, pool),
                                            second.of(is_exchanged ? left : right, pool), pool);
    std::vector<Match> matches;
    for (const Match& match : found) {
        Match taken{first.in_picture(match.left), second.in_picture(match.right)};
        if (!first.is_inside(taken.left) || !second.is_inside(taken.right)) continue;
        if (is_exchanged) std::swap(taken.left, taken.right);
        matches.push_back(taken);
    }
    return matches;
}

}  // namespace hexrelief::alignment
