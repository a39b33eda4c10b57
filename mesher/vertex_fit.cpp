#include <algorithm>
#include <cmath>
#include <limits>

#include "mesher/sheet_parts.h"
#include "mesher/steps/vertex_fit.h"
#include "mesher/team.h"

namespace hexrelief {
namespace {

constexpr int kRounds = 3;             // of reweighting
constexpr int kSweeps = 12;            // of the linear solver a round
constexpr double kDamping = 0.8;       // 2 / (1/2 + 2), the extreme eigenvalues of a triangle's scaled sums
constexpr double kPull = 0.05;         // towards the vertex's own plane, in pixels' weights
constexpr float kSlack_px = 1.5f;      // of a vertex beyond the range of the pixels around it,
constexpr float kSlackShare = 0.25f;   // and as a share of its longest edge
constexpr double kTolerance_px = 1.0;  // residuals beyond count less

struct CornerTable {
    std::vector<std::uint32_t> starts, items;  // of each vertex: 3 * triangle + corner, ascending
};

CornerTable corners_of(const std::vector<Triangle>& triangles, std::size_t vertices) {
    CornerTable table{std::vector<std::uint32_t>(vertices + 1, 0),
                      std::vector<std::uint32_t>(3 * triangles.size())};
    for (const Triangle& t : triangles)
        for (const std::uint32_t v : t) ++table.starts[v + 1];
    for (std::size_t v = 1; v <= vertices; ++v) table.starts[v] += table.starts[v - 1];
    std::vector<std::uint32_t> next(table.starts.begin(), table.starts.end() - 1);
    for (std::uint32_t i = 0; i < table.items.size(); ++i) table.items[next[triangles[i / 3][i % 3]]++] = i;
    return table;
}

class Fitter {
  public:
    Fitter(const PixelSurfaces& surfaces, const std::vector<Vec2f>& points,
           const std::vector<Triangle>& triangles, const TriangleSides& sides,
           const std::vector<std::uint32_t>& origins, Team& team)
        : view_(surfaces.view()),
          points_(points),
          triangles_(triangles),
          sides_(sides),
          origins_(origins),
          corners_(corners_of(triangles, points.size())),
          team_(team) {}

    std::vector<float> run() {
        find_floor();
        start_from_planes();
        planes_ = values_;
        for (int round = 0; round < kRounds; ++round) {
            gather_sums();
            for (int sweep = 0; sweep < kSweeps; ++sweep) relax();
        }
        return {values_.begin(), values_.end()};
    }

  private:
    std::uint32_t first_pixel(std::size_t t) const { return sides_.starts[origins_[t]]; }
    std::uint32_t end_pixel(std::size_t t) const { return sides_.starts[origins_[t] + 1]; }

    // Calls visit(triangle) for the triangles at v and, in the second ring, at their other vertices.
    template <typename Visit>
    void each_triangle(std::size_t v, bool second_ring, const Visit& visit) const {
        for (std::uint32_t i = corners_.starts[v]; i < corners_.starts[v + 1]; ++i) {
            const std::uint32_t t = corners_.items[i] / 3;
            if (!second_ring) {
                visit(t);
                continue;
            }
            for (const std::uint32_t u : triangles_[t])
                for (std::uint32_t j = corners_.starts[u]; j < corners_.starts[u + 1]; ++j)
                    visit(corners_.items[j] / 3);
        }
    }
    void start_from_planes() {
        std::vector<step::Moments> moments(triangles_.size());
        team_.for_ranges(triangles_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t t = first; t < last; ++t)
                for (std::uint32_t i = first_pixel(t); i < end_pixel(t); ++i) {
                    const std::uint32_t p = sides_.pixels[i], w = static_cast<std::uint32_t>(view_.width);
                    step::add_pixel(moments[t], static_cast<int>(p % w), static_cast<int>(p / w),
                                    view_.disparity[p]);
                }
        });
        values_.assign(points_.size(), 0);
        least_.assign(points_.size(), 0);
        most_.assign(points_.size(), 0);
        std::vector<std::uint8_t> known(points_.size(), 0);
        team_.for_ranges(points_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                step::Moments sum;
                each_triangle(v, false, [&](std::uint32_t t) { step::add_moments(sum, moments[t]); });
                if (!step::holds_plane(sum)) {
                    sum = {};
                    each_triangle(v, true, [&](std::uint32_t t) { step::add_moments(sum, moments[t]); });
                }
                if (!(sum.n > 0)) continue;
                const float longest = reach(v);
                // Slivers at rims hold few pixels: without bounds some vertices would end far from all of
                // them.
                const float slack = kSlack_px + kSlackShare * longest;
                least_[v] =
                    std::max(std::max(0.5f * sum.least, sum.least - slack), static_cast<float>(floor_));
                most_[v] = std::max(least_[v], sum.most + slack);
                values_[v] = step::clamp_to(step::plane_at(sum, points_[v].x, points_[v].y, longest),
                                            double(least_[v]), double(most_[v]));
                known[v] = 1;
            }
        });
        fill_unknown(known);
        for (std::size_t v = 0; v < known.size(); ++v)
            if (!(most_[v] > 0)) least_[v] = most_[v] = static_cast<float>(values_[v]);
    }
    // The longest edge at v: no surface that both cameras see changes by more over it.
    float reach(std::size_t v) const {
        float longest = 0;
        for (std::uint32_t i = corners_.starts[v]; i < corners_.starts[v + 1]; ++i)
            for (const std::uint32_t u : triangles_[corners_.items[i] / 3]) {
                const float dx = points_[u].x - points_[v].x, dy = points_[u].y - points_[v].y;
                longest = std::max(longest, dx * dx + dy * dy);
            }
        return std::sqrt(longest);
    }
    // Vertices far from any pixel that counts (all specks): the mean of their neighbours, ring by ring; where
    // a whole component has none, its own pixels' disparity.
    void fill_unknown(std::vector<std::uint8_t>& known) {
        for (bool moved = true; moved;) {
            moved = false;
            std::vector<std::pair<std::size_t, double>> found;
            for (std::size_t v = 0; v < known.size(); ++v) {
                if (known[v]) continue;
                double sum = 0;
                int count = 0;
                each_triangle(v, false, [&](std::uint32_t t) {
                    for (const std::uint32_t u : triangles_[t])
                        if (known[u]) sum += values_[u], ++count;
                });
                if (count > 0) found.emplace_back(v, sum / count);
            }
            for (const auto& [v, value] : found) values_[v] = value, known[v] = 1, moved = true;
        }
        for (std::size_t v = 0; v < known.size(); ++v) {
            if (known[v]) continue;
            const int x = std::clamp(static_cast<int>(points_[v].x), 0, view_.width - 1),
                      y = std::clamp(static_cast<int>(points_[v].y), 0, view_.height - 1);
            values_[v] = std::max<double>(floor_, view_.disparity[view_.index(x, y)]);
        }
    }
    // Planes reach beyond their pixels; half of the smallest disparity that is meant keeps them from
    // infinity.
    void find_floor() {
        float smallest = std::numeric_limits<float>::max();
        const std::size_t pixels = static_cast<std::size_t>(view_.width) * view_.height;
        for (std::size_t i = 0; i < pixels; ++i)
            if (view_.disparity[i] > 0) smallest = std::min(smallest, view_.disparity[i]);
        floor_ = std::max(1e-3, 0.5 * static_cast<double>(smallest));
    }
    void gather_sums() {
        sums_.assign(triangles_.size(), {});
        team_.for_ranges(triangles_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t t = first; t < last; ++t) gather_sums(t);
        });
    }
    void gather_sums(std::size_t t) {
        const Triangle& v = triangles_[t];
        const Vec2f &a = points_[v[0]], &b = points_[v[1]], &c = points_[v[2]];
        const double abx = double(b.x) - a.x, aby = double(b.y) - a.y, acx = double(c.x) - a.x,
                     acy = double(c.y) - a.y;
        const double area = abx * acy - aby * acx;
        const double base = values_[v[0]], d1 = values_[v[1]] - base, d2 = values_[v[2]] - base;
        const std::uint32_t w = static_cast<std::uint32_t>(view_.width);
        for (std::uint32_t i = first_pixel(t); i < end_pixel(t); ++i) {
            const std::uint32_t p = sides_.pixels[i];
            const double x = static_cast<double>(p % w) + 0.5 - a.x,
                         y = static_cast<double>(p / w) + 0.5 - a.y;
            const double l1 = (x * acy - y * acx) / area, l2 = (abx * y - aby * x) / area;
            const double d = view_.disparity[p];
            const double weight = step::huber_weight(base + l1 * d1 + l2 * d2 - d, kTolerance_px);
            step::add_pixel(sums_[t], 1 - l1 - l2, l1, l2, d, weight);
        }
    }
    void relax() {
        next_.resize(values_.size());
        team_.for_ranges(values_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                double diagonal = kPull, right = kPull * planes_[v];
                for (std::uint32_t i = corners_.starts[v]; i < corners_.starts[v + 1]; ++i) {
                    const std::uint32_t t = corners_.items[i] / 3, k = corners_.items[i] % 3;
                    step::add_corner(sums_[t], static_cast<int>(k), values_[triangles_[t][(k + 1) % 3]],
                                     values_[triangles_[t][(k + 2) % 3]], diagonal, right);
                }
                next_[v] = step::clamp_to(values_[v] + kDamping * (right / diagonal - values_[v]),
                                          double(least_[v]), double(most_[v]));
            }
        });
        values_.swap(next_);
    }

    step::PixelView view_;
    const std::vector<Vec2f>& points_;
    const std::vector<Triangle>& triangles_;
    const TriangleSides& sides_;
    const std::vector<std::uint32_t>& origins_;
    CornerTable corners_;
    Team& team_;
    std::vector<double> values_, next_, planes_;  // disparities
    double floor_ = 0;                            // of all of them
    std::vector<float> least_, most_;             // bounds of them
    std::vector<step::TriangleSums> sums_;
};

}  // namespace

std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const std::vector<Vec2f>& points,
                                   const std::vector<Triangle>& triangles, const TriangleSides& sides,
                                   const std::vector<std::uint32_t>& origins, Team& team) {
    return Fitter(surfaces, points, triangles, sides, origins, team).run();
}

}  // namespace hexrelief
