#include "pipeline/stages/surface_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "mesher/common/thread_pool.h"

namespace hexrelief {
namespace {

constexpr double kEdge_px =
    1e-6;  // this far outside counts as on the edge, so that shared edges leave no gaps
constexpr double kNoArea = 1e-12;  // twice a triangle's area

// Pixels whose centres lie in [low, high], cut to 0..size-1; empty where first > last.
struct Span {
    int first, last;
};
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

// The pixels in a triangle, row by row.
struct Filler {
    std::array<ViewPoint, 3> p;
    std::array<double, 3> slack;  // of the edges from each point to the next
    double area;                  // twice, signed
    double low, high, slope_x, slope_y;

    Filler(const ViewPoint& a, const ViewPoint& b, const ViewPoint& c) : p{a, b, c} {
        area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if (area < 0) {  // the other view sees its back
            std::swap(p[1], p[2]);
            area = -area;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const ViewPoint &from = p[k], &to = p[(k + 1) % 3];
            const double ex = to.x - from.x, ey = to.y - from.y;
            slack[k] = kEdge_px * std::sqrt(ex * ex + ey * ey);
        }
        low = lowest(a.d, b.d, c.d);
        high = highest(a.d, b.d, c.d);
        const ViewPoint &o = p[0], &u = p[1], &v = p[2];
        slope_x = ((u.d - o.d) * (v.y - o.y) - (v.d - o.d) * (u.y - o.y)) / area;
        slope_y = ((v.d - o.d) * (u.x - o.x) - (u.d - o.d) * (v.x - o.x)) / area;
    }

    // Columns whose centres lie inside, on the line through the centres of row y.
    Span columns(int y, int width) const {
        double from = lowest(p[0].x, p[1].x, p[2].x) - kEdge_px,
               to = highest(p[0].x, p[1].x, p[2].x) + kEdge_px;
        for (std::size_t k = 0; k < 3; ++k) {
            const ViewPoint &a = p[k], &b = p[(k + 1) % 3];
            const double ex = b.x - a.x, ey = b.y - a.y;
            const double above = ex * (y + 0.5 - a.y) + slack[k];
            // inside: above - ey * (x - a.x) >= 0
            if (ey > 0)
                to = std::min(to, a.x + above / ey);
            else if (ey < 0)
                from = std::max(from, a.x + above / ey);
            else if (above < 0)
                return {0, -1};
        }
        return centres(from, to, 0, width - 1);
    }

    // put(x, disparity) for each of them.
    template <typename Put>
    void fill(int y, int width, const Put& put) const {
        const Span span = columns(y, width);
        const double start = p[0].d + slope_y * (y + 0.5 - p[0].y);
        for (int x = span.first; x <= span.last; ++x)
            put(x, std::clamp(start + slope_x * (x + 0.5 - p[0].x), low, high));
    }
};

// fill(filler, y) for each row from `begin` to before `end` that has pixels in the triangle.
template <typename Fill>
void for_rows_of(const View& view, const Triangle& t, int begin, int end, const Fill& fill) {
    const ViewPoint &a = view.points[t[0]], &b = view.points[t[1]], &c = view.points[t[2]];
    const Span rows =
        centres(lowest(a.y, b.y, c.y) - kEdge_px, highest(a.y, b.y, c.y) + kEdge_px, begin, end - 1);
    if (rows.first > rows.last) return;
    const Filler filler(a, b, c);
    if (filler.area < kNoArea) return;
    for (int y = rows.first; y <= rows.last; ++y) fill(filler, y);
}

// Squared distance from (x, y) to the segment, and the disparity of its nearest point.
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

std::vector<double> rasterise_disparity(const View& view, int threads) {
    std::vector<double> top(static_cast<std::size_t>(view.width) * view.height, kNotCovered);
    for_row_bands(view.height, threads, [&](int begin, int end) {
        for (const Triangle& t : *view.triangles)
            for_rows_of(view, t, begin, end, [&](const Filler& filler, int y) {
                double* const row = &top[static_cast<std::size_t>(y) * view.width];
                filler.fill(y, view.width, [row](int x, double d) { row[x] = std::max(row[x], d); });
            });
    });
    return top;
}

void scan_pixels(const View& view, const std::function<void(int, int, std::span<const double>)>& take) {
    std::vector<double> row;
    for (const Triangle& t : *view.triangles)
        for_rows_of(view, t, 0, view.height, [&](const Filler& filler, int y) {
            row.clear();
            int end = 0;
            filler.fill(y, view.width, [&](int x, double d) {
                row.push_back(d);
                end = x + 1;
            });
            if (!row.empty()) take(end - static_cast<int>(row.size()), y, row);
        });
}

void fill_within(std::vector<double>& covered, const std::vector<char>& wanted, const View& view,
                 double slack_px, int threads) {
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

}  // namespace hexrelief
