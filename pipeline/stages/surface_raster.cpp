#include "pipeline/stages/surface_raster.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "pipeline/base/thread_pool.h"

namespace hexrelief::stages {
namespace {

// Points this far outside count as on the edge, so that shared edges leave no gaps.
constexpr double kEdge_px = 1e-6;
constexpr double kNoArea = 1e-12;  // least value of twice a triangle's area

// The pixels first .. last; empty if first > last.
struct Span {
    int first, last;
};
// Returns the pixels of first .. last whose centres lie in [low, high].
Span centres(double low, double high, int first, int last) {
    // clamped before the conversion to int, because vertices may lie far outside
    const double from = std::max(std::ceil(low - 0.5), double(first)),
                 to = std::min(std::floor(high - 0.5), double(last));
    return from > to ? Span{0, -1} : Span{int(from), int(to)};
}

double lowest(double a, double b, double c) {
    return std::min(a, std::min(b, c));
}
double highest(double a, double b, double c) {
    return std::max(a, std::max(b, c));
}

// Finds the pixels in a triangle, row by row.
struct Filler {
    // A line through (x, y), parallel to an edge and kEdge_px outside of the triangle.
    struct Side {
        double x, y, slope;
        double column(double at_y) const { return x + slope * (at_y - y); }
    };
    ViewPoint origin;
    double left, right;                // columns that bound all pixels
    std::array<Side, 2> from{}, to{};  // lines that bound a row's pixels on the left and on the right
    int froms = 0, tos = 0;
    double area;  // twice the triangle's area
    double low, high, slope_x, slope_y;

    Filler(const ViewPoint& a, const ViewPoint& b, const ViewPoint& c) : origin(a) {
        area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        std::array<const ViewPoint*, 3> p{&a, &b, &c};
        if (area < 0) {  // the other view sees the triangle's back
            std::swap(p[1], p[2]);
            area = -area;
        }
        if (area < kNoArea) return;
        for (std::size_t k = 0; k < 3; ++k) {
            const ViewPoint &u = *p[k], &v = *p[(k + 1) % 3];
            const double ex = v.x - u.x, ey = v.y - u.y;
            if (ey == 0) continue;  // a horizontal edge excludes no centre of the rows that are visited
            // inside: ex * (y + 0.5 - u.y) + slack - ey * (x - u.x) >= 0
            const double slack = kEdge_px * std::sqrt(ex * ex + ey * ey), slope = ex / ey;
            const Side side{u.x + slack / ey, u.y, slope};
            if (ey > 0)
                to[static_cast<std::size_t>(tos++)] = side;
            else
                from[static_cast<std::size_t>(froms++)] = side;
        }
        left = lowest(a.x, b.x, c.x) - kEdge_px;
        right = highest(a.x, b.x, c.x) + kEdge_px;
        low = lowest(a.d, b.d, c.d);
        high = highest(a.d, b.d, c.d);
        const ViewPoint &u = *p[1], &v = *p[2];
        slope_x = ((u.d - a.d) * (v.y - a.y) - (v.d - a.d) * (u.y - a.y)) / area;
        slope_y = ((v.d - a.d) * (u.x - a.x) - (u.d - a.d) * (v.x - a.x)) / area;
    }

    // Returns the columns of row y whose centres lie inside.
    Span columns(int y, int width) const {
        double first = left, last = right;
        for (int k = 0; k < froms; ++k)
            first = std::max(first, from[static_cast<std::size_t>(k)].column(y + 0.5));
        for (int k = 0; k < tos; ++k) last = std::min(last, to[static_cast<std::size_t>(k)].column(y + 0.5));
        return centres(first, last, 0, width - 1);
    }

    // Returns the run of the triangle's pixels in row y.
    PixelRun run(int y, int width) const {
        const Span span = columns(y, width);
        return {span.first,
                y,
                std::max(0, span.last - span.first + 1),
                origin.d + slope_y * (y + 0.5 - origin.y) + slope_x * (span.first + 0.5 - origin.x),
                slope_x,
                low,
                high};
    }
};

// Calls fill(filler, y) for each row_step-th row from `begin` to before `end` that may have
// pixels in the triangle.
template <typename Fill>
void for_rows_of(const View& view, const Triangle& t, int begin, int end, int row_step, const Fill& fill) {
    const ViewPoint &a = view.points[t[0]], &b = view.points[t[1]], &c = view.points[t[2]];
    const Span rows =
        centres(lowest(a.y, b.y, c.y) - kEdge_px, highest(a.y, b.y, c.y) + kEdge_px, begin, end - 1);
    const int first = begin + (rows.first - begin + row_step - 1) / row_step * row_step;
    if (first > rows.last) return;
    const Filler filler(a, b, c);
    if (filler.area < kNoArea) return;
    for (int y = first; y <= rows.last; y += row_step) fill(filler, y);
}

// The squared distance from (x, y) to a segment, and the disparity of the segment's nearest point.
struct Nearest {
    double squared, d;
};
Nearest nearest_of(const ViewPoint& a, const ViewPoint& b, double x, double y) {
    const double ex = b.x - a.x, ey = b.y - a.y, size = ex * ex + ey * ey;
    const double t = size > 0 ? std::clamp(((x - a.x) * ex + (y - a.y) * ey) / size, 0.0, 1.0) : 0;
    const double dx = a.x + t * ex - x, dy = a.y + t * ey - y;
    return {dx * dx + dy * dy, a.d + t * (b.d - a.d)};
}

}  // namespace

void for_row_bands(int height, int threads, const std::function<void(int, int)>& work) {
    const int bands = std::max(1, std::min(threads, height));
    ThreadPool pool(bands);
    pool.parallel_for(static_cast<std::size_t>(height), [&](std::size_t begin, std::size_t end) {
        work(static_cast<int>(begin), static_cast<int>(end));
    });
}

namespace {

void rasterise_rows(Disparities& shown, const View& view, int begin, int end) {
    for (const Triangle& t : *view.triangles)
        for_rows_of(view, t, begin, end, 1, [&](const Filler& filler, int y) {
            const PixelRun run = filler.run(y, view.width);
            double* const row = &shown[static_cast<std::size_t>(y) * view.width + run.x];
            for (int i = 0; i < run.count; ++i) row[i] = std::max(row[i], run.disparity(i));
        });
}

}  // namespace

Disparities rasterise_disparity(const View& view, int threads) {
    Disparities shown(static_cast<std::size_t>(view.width) * view.height);
    for_row_bands(view.height, threads, [&](int begin, int end) {
        const auto row = [&](int y) { return shown.begin() + static_cast<std::ptrdiff_t>(y) * view.width; };
        std::fill(row(begin), row(end), kNotCovered);
        rasterise_rows(shown, view, begin, end);
    });
    return shown;
}

std::vector<char> rasterise_coverage(const View& view, int threads) {
    std::vector<char> is_covered(static_cast<std::size_t>(view.width) * view.height);
    for_row_bands(view.height, threads, [&](int begin, int end) {
        for (const Triangle& t : *view.triangles)
            for_rows_of(view, t, begin, end, 1, [&](const Filler& filler, int y) {
                const Span span = filler.columns(y, view.width);
                char* const row = &is_covered[static_cast<std::size_t>(y) * view.width];
                if (span.first <= span.last) std::fill(row + span.first, row + span.last + 1, char{1});
            });
    });
    return is_covered;
}

void rasterise_over(Disparities& shown, const View& view, int threads) {
    for_row_bands(view.height, threads, [&](int begin, int end) { rasterise_rows(shown, view, begin, end); });
}

void scan_pixels(const View& view, int row_step, const std::function<void(const PixelRun&)>& take) {
    for (const Triangle& t : *view.triangles)
        for_rows_of(view, t, 0, view.height, row_step, [&](const Filler& filler, int y) {
            const PixelRun run = filler.run(y, view.width);
            if (run.count > 0) take(run);
        });
}

void fill_within(Disparities& covered, const std::vector<char>& wanted, const View& view, double slack_px,
                 int threads) {
    std::vector<char> open(covered.size());
    for (std::size_t i = 0; i < open.size(); ++i) open[i] = wanted[i] && covered[i] == kNotCovered;
    std::vector<double> best(covered.size(), slack_px * slack_px);
    for_row_bands(view.height, threads, [&](int begin, int end) {
        for (const Triangle& t : *view.triangles) {
            const ViewPoint* const p[3] = {&view.points[t[0]], &view.points[t[1]], &view.points[t[2]]};
            const Span rows = centres(lowest(p[0]->y, p[1]->y, p[2]->y) - slack_px,
                                      highest(p[0]->y, p[1]->y, p[2]->y) + slack_px, begin, end - 1);
            const Span columns = centres(lowest(p[0]->x, p[1]->x, p[2]->x) - slack_px,
                                         highest(p[0]->x, p[1]->x, p[2]->x) + slack_px, 0, view.width - 1);
            for (int y = rows.first; y <= rows.last; ++y)
                for (int x = columns.first; x <= columns.last; ++x) {
                    const std::size_t i = static_cast<std::size_t>(y) * view.width + x;
                    if (!open[i]) continue;
                    // outside of all triangles, so the nearest point lies on an edge
                    for (int k = 0; k < 3; ++k) {
                        const Nearest nearest = nearest_of(*p[k], *p[(k + 1) % 3], x + 0.5, y + 0.5);
                        if (nearest.squared > best[i] ||
                            (nearest.squared == best[i] && nearest.d <= covered[i]))
                            continue;
                        best[i] = nearest.squared;
                        covered[i] = nearest.d;
                    }
                }
        }
    });
}

}  // namespace hexrelief::stages
