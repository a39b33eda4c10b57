#include "pipeline/stages/other_views/pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <ranges>
#include <tuple>
#include <vector>

#include "pipeline/data/union_find.h"
#include "pipeline/stages/surface.h"

namespace hexrelief::stages {
namespace {

constexpr double kEnd_px = 2;              // of a strip at either end, where it goes behind the surface
constexpr double kHardlyInFront_px = 0.1;  // at the ends it is level with the surface
constexpr double kMostStep_px = 3;         // of a strip: higher ones are seen from the side
constexpr double kLeastTurn_px2 = 0.1;     // of a strip's triangles: they face the camera

// The corners of a strip by rows, from the first side to the other.
using Strip = std::array<std::array<ViewPoint, 2>, 4>;

// A side of the mesh's border, in the order of its triangle.
struct BorderSide {
    std::uint32_t a, b;
    double x, y;           // of its middle
    float least, largest;  // disparity
};

std::vector<BorderSide> border_of(const SurfaceMesh& mesh) {
    const std::size_t vertices = mesh.image_points.size();
    std::vector<std::uint32_t> begins(vertices + 1), ends;  // of the sides that begin at a vertex
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) ++begins[v + 1];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    ends.resize(begins.back());
    std::vector<std::uint32_t> next(begins.begin(), begins.end() - 1);
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) ends[next[t[k]]++] = t[(k + 1) % 3];
    const auto is_side = [&](std::uint32_t a, std::uint32_t b) {
        const auto last = ends.begin() + begins[a + 1];
        return std::find(ends.begin() + begins[a], last, b) != last;
    };
    std::vector<BorderSide> border;
    for (std::uint32_t a = 0; a < vertices; ++a)
        for (std::uint32_t i = begins[a]; i < begins[a + 1]; ++i) {
            const std::uint32_t b = ends[i];
            if (is_side(b, a)) continue;
            const Vec2f &p = mesh.image_points[a], &q = mesh.image_points[b];
            const auto [least, largest] = std::minmax(mesh.disparities[a], mesh.disparities[b]);
            border.push_back({a, b, (double(p.x) + q.x) / 2, (double(p.y) + q.y) / 2, least, largest});
        }
    return border;
}

// The sides by the squares of the left view in which their middles lie.
class BorderGrid {
  public:
    explicit BorderGrid(const std::vector<BorderSide>& border) {
        if (border.empty()) return;
        const auto [left, right] = std::ranges::minmax(border | std::views::transform(&BorderSide::x));
        const auto [top, bottom] = std::ranges::minmax(border | std::views::transform(&BorderSide::y));
        left_ = left;
        top_ = top;
        columns_ = 1 + static_cast<int>((right - left) / kSquare_px);
        rows_ = 1 + static_cast<int>((bottom - top) / kSquare_px);
        squares_.resize(static_cast<std::size_t>(columns_) * rows_);
        for (std::uint32_t i = 0; i < border.size(); ++i)
            squares_[at(column_of(border[i]), row_of(border[i]))].push_back(i);
    }
    // Calls take(side) for the sides within reach_px of one, ring by ring of squares, until it has returned
    // true for enough.
    template <class Take>
    void for_nearest(const BorderSide& from, double reach_px, const Take& take) const {
        const int column = column_of(from), row = row_of(from);
        int taken = 0;
        for (int ring = 0; ring <= 1 + static_cast<int>(reach_px / kSquare_px) && taken < kMostTried; ++ring)
            for (int y = std::max(0, row - ring); y <= std::min(rows_ - 1, row + ring); ++y) {
                const int step = y == row - ring || y == row + ring ? 1 : std::max(1, 2 * ring);
                for (int x = column - ring; x <= column + ring; x += step)
                    if (x >= 0 && x < columns_)
                        for (const std::uint32_t side : squares_[at(x, y)]) taken += take(side);
            }
    }

  private:
    static constexpr int kSquare_px = 16, kMostTried = 40;

    int column_of(const BorderSide& side) const { return static_cast<int>((side.x - left_) / kSquare_px); }
    int row_of(const BorderSide& side) const { return static_cast<int>((side.y - top_) / kSquare_px); }
    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * columns_ + x; }

    double left_ = 0, top_ = 0;
    int columns_ = 0, rows_ = 0;
    std::vector<std::vector<std::uint32_t>> squares_;
};

// True if the surface covers a triangle of the left view in all views that show it, and the triangle faces
// the camera.
bool is_unseen(const ViewPoint& a, const ViewPoint& b, const ViewPoint& c, const VisibleSurface& surface,
               double most_in_front_px) {
    if ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y) > -kLeastTurn_px2) return false;
    const double longest = std::max({std::hypot(b.x - a.x, b.y - a.y), std::hypot(c.x - a.x, c.y - a.y),
                                     std::hypot(c.x - b.x, c.y - b.y)});
    const int steps = 1 + static_cast<int>(longest);
    for (const SeenSurface& seen : surface.seen)
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; i + j <= steps; ++j) {
                const double u = static_cast<double>(i) / steps, v = static_cast<double>(j) / steps,
                             w = 1 - u - v;
                const ViewPoint p = seen.place.from_left(
                    {u * a.x + v * b.x + w * c.x, u * a.y + v * b.y + w * c.y, u * a.d + v * b.d + w * c.d});
                if (!(p.x >= 0 && p.x < seen.place.width && p.y >= 0 && p.y < seen.place.height)) continue;
                const double front = seen.disparities[static_cast<std::size_t>(p.y) * seen.place.width +
                                                      static_cast<std::size_t>(p.x)];
                if (front == kNotCovered || (p.d - front) * seen.place.scale > most_in_front_px) return false;
            }
    return true;
}

bool is_in_a_view(const ViewPoint& in_left, const VisibleSurface& surface) {
    return std::ranges::any_of(surface.seen, [&](const SeenSurface& seen) {
        const ViewPoint p = seen.place.from_left(in_left);
        return p.x >= 0 && p.x < seen.place.width && p.y >= 0 && p.y < seen.place.height;
    });
}

// Returns the strip between two sides, if there is one that no camera sees.
std::optional<Strip> strip_between(const SurfaceMesh& mesh, const BorderSide& from, const BorderSide& to,
                                   const VisibleSurface& surface, bool only_in_views) {
    const ViewPlace& left = surface.seen[0].place;
    const auto point = [&](std::uint32_t v) {
        return ViewPoint{mesh.image_points[v].x, mesh.image_points[v].y, mesh.disparities[v]};
    };
    Strip strip;
    strip.front() = {point(from.a), point(from.b)};
    strip.back() = {point(to.b), point(to.a)};
    for (std::size_t rail = 0; rail < 2; ++rail) {
        const ViewPoint p = strip.front()[rail], q = strip.back()[rail];
        const double length = std::hypot(q.x - p.x, q.y - p.y), end = std::min(1. / 3, kEnd_px / length);
        for (const std::size_t row : {1, 2}) {
            const double s = row == 1 ? end : 1 - end;
            ViewPoint& at = strip[row][rail];
            at = {p.x + s * (q.x - p.x), p.y + s * (q.y - p.y), p.d + s * (q.d - p.d)};
            at.d = behind(at, left, surface);
            if (!DisparityMap::known(static_cast<float>(at.d)) ||
                (only_in_views && !is_in_a_view(at, surface)))
                return std::nullopt;
        }
    }
    double least = strip[0][0].d, largest = least;
    for (const auto& row : strip)
        for (const ViewPoint& p : row) {
            least = std::min(least, p.d);
            largest = std::max(largest, p.d);
        }
    if (largest - least > kMostStep_px) return std::nullopt;
    for (std::size_t row = 0; row < 3; ++row) {
        const auto& [p, q] = strip[row];
        const auto& [r, s] = strip[row + 1];
        const double most_in_front_px = row == 1 ? 0 : kHardlyInFront_px;
        if (!is_unseen(q, p, r, surface, most_in_front_px) || !is_unseen(q, r, s, surface, most_in_front_px))
            return std::nullopt;
    }
    return strip;
}

void add_strip(SurfaceMesh& mesh, const Strip& strip, const BorderSide& from, const BorderSide& to,
               const Calibration& camera) {
    std::array<std::uint32_t, 2> before = {from.a, from.b};
    for (std::size_t row = 1; row < strip.size(); ++row) {
        std::array<std::uint32_t, 2> here = {to.b, to.a};
        for (std::size_t rail = 0; rail < 2 && row < 3; ++rail) {
            const ViewPoint& p = strip[row][rail];
            const std::uint32_t end = rail == 0 ? from.a : from.b;
            here[rail] = static_cast<std::uint32_t>(mesh.positions.size());
            const auto [x, y, z] = position_in_space(p.x, p.y, p.d, camera);
            mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
            mesh.normals.push_back(Vec3f(mesh.normals[end]));
            mesh.texcoords.push_back(Vec2f(mesh.texcoords[end]));
            mesh.image_points.push_back({static_cast<float>(p.x), static_cast<float>(p.y)});
            mesh.disparities.push_back(static_cast<float>(p.d));
        }
        mesh.triangles.push_back({before[1], before[0], here[0]});
        mesh.triangles.push_back({before[1], here[0], here[1]});
        before = here;
    }
}

}  // namespace

void join_pieces(SurfaceMesh& mesh, const VisibleSurface& visible, const Calibration& camera,
                 const PieceStrips& strips) {
    UnionFind pieces(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) {
        pieces.join(t[0], t[1]);
        pieces.join(t[0], t[2]);
    }
    std::vector<std::size_t> sizes(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) ++sizes[pieces.find(t[0])];
    const std::vector<BorderSide> border = border_of(mesh);
    const BorderGrid grid(border);
    std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> pairs;  // distances, and two sides
    for (std::uint32_t i = 0; i < border.size(); ++i) {
        const BorderSide& from = border[i];
        const std::uint32_t own = pieces.find(from.a);
        if (sizes[own] >= strips.least) continue;
        grid.for_nearest(from, strips.reach_px, [&](std::uint32_t k) {
            const BorderSide& to = border[k];
            const double distance = std::hypot(to.x - from.x, to.y - from.y);
            if (distance > strips.reach_px || pieces.find(to.a) == own ||
                std::max(to.largest, from.largest) - std::min(to.least, from.least) > kMostStep_px)
                return false;
            pairs.emplace_back(distance, i, k);
            return true;
        });
    }
    std::sort(pairs.begin(), pairs.end());
    std::vector<char> is_used(border.size());
    for (const auto& [distance, i, k] : pairs) {
        const std::uint32_t from = pieces.find(border[i].a), to = pieces.find(border[k].a);
        if (from == to || std::min(sizes[from], sizes[to]) >= strips.least || is_used[i] || is_used[k])
            continue;
        const std::optional<Strip> strip =
            strip_between(mesh, border[i], border[k], visible, strips.only_in_views);
        if (!strip) continue;
        add_strip(mesh, *strip, border[i], border[k], camera);
        is_used[i] = is_used[k] = 1;
        pieces.join(from, to);
        sizes[std::min(from, to)] = sizes[from] + sizes[to] + 2 * (strip->size() - 1);
    }
}

}  // namespace hexrelief::stages
