#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "mesher/buckets.h"
#include "mesher/sheet_parts.h"
#include "mesher/steps/vertex_fit.h"
#include "mesher/team.h"

namespace hexrelief {
namespace {

constexpr int kRounds = 3;             // of reweighting
constexpr int kSweeps = 6;             // of the linear solver a round
constexpr double kDamping = 0.8;       // 2 / (1/2 + 2), the extreme eigenvalues of a triangle's scaled sums
constexpr double kPull = 0.05;         // towards the vertex's own plane, in pixels' weights
constexpr float kSlack_px = 1.5f;      // of a vertex beyond the range of the pixels around it,
constexpr float kSlackShare = 0.25f;   // and as a share of its longest edge
constexpr double kTolerance_px = 1.0;  // residuals beyond count less

// Of each vertex: 3 * triangle + corner, ascending.
Buckets corners_of(const std::vector<Triangle>& triangles, std::size_t vertices) {
    return sort_into(vertices, [&](const auto& put) {
        for (std::uint32_t i = 0; i < 3 * triangles.size(); ++i) put(triangles[i / 3][i % 3], i);
    });
}

// Pixels of a triangle, for loops over several at once.
struct PixelBatch {
    static constexpr int kMost = 64;
    int count = 0;
    double x[kMost], y[kMost], d[kMost];
    double l1[kMost], l2[kMost], weight[kMost];
};

#if defined(__x86_64__)
__attribute__((target_clones("avx512f", "avx2", "default")))
#endif
void weigh(PixelBatch& batch, const step::PlanePatch& patch) {
    for (int i = 0; i < batch.count; ++i)
        step::weigh_pixel(patch, batch.x[i], batch.y[i], batch.d[i], kTolerance_px, batch.l1[i], batch.l2[i],
                          batch.weight[i]);
}

// Adds the pixels, in their order, and empties the batch.
void flush(PixelBatch& batch, const step::PlanePatch& patch, step::TriangleSums& sums) {
    weigh(batch, patch);
    for (int i = 0; i < batch.count; ++i)
        step::add_pixel(sums, 1 - batch.l1[i] - batch.l2[i], batch.l1[i], batch.l2[i], batch.d[i],
                        batch.weight[i]);
    batch.count = 0;
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
        terms_.resize(corners_.items.size());
        diagonals_.resize(points_.size());
        for (int round = 0; round < kRounds; ++round) {
            gather_sums();
            for (int sweep = 0; sweep < kSweeps; ++sweep) relax();
        }
        return {values_.begin(), values_.end()};
    }

  private:
    std::span<const PixelRun> pixel_runs(std::size_t t) const {
        const std::uint32_t* start = &sides_.starts[origins_[t]];
        return {sides_.runs.data() + start[0], start[1] - start[0]};
    }

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
                for (const PixelRun& run : pixel_runs(t))
                    for (int x = run.first; x < run.end; ++x)
                        step::add_pixel(moments[t], x, run.y, view_.disparity[view_.index(x, run.y)]);
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
    // a whole component has none, its triangles' own surface.
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
            const std::uint32_t t = corners_.items[corners_.starts[v]] / 3;
            values_[v] = std::max<double>(floor_, view_.disparity[sides_.anchors[origins_[t]]]);
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
    // The normal equations with the present residuals' weights, and for each vertex what a sweep needs of
    // them.
    void gather_sums() {
        sums_.resize(triangles_.size());
        team_.for_ranges(triangles_.size(), [&](std::size_t first, std::size_t last) {
            PixelBatch batch;
            for (std::size_t t = first; t < last; ++t) gather_sums(t, batch);
        });
        team_.for_ranges(points_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                double diagonal = kPull;
                for (std::uint32_t i = corners_.starts[v]; i < corners_.starts[v + 1]; ++i) {
                    const std::uint32_t t = corners_.items[i] / 3, k = corners_.items[i] % 3;
                    const Triangle& u = triangles_[t];
                    terms_[i] = {step::corner_row(sums_[t], static_cast<int>(k)), u[(k + 1) % 3],
                                 u[(k + 2) % 3]};
                    diagonal += terms_[i].row.own;
                }
                diagonals_[v] = diagonal;
            }
        });
    }
    void gather_sums(std::size_t t, PixelBatch& batch) {
        const Triangle& v = triangles_[t];
        const Vec2f &a = points_[v[0]], &b = points_[v[1]], &c = points_[v[2]];
        const step::PlanePatch patch =
            step::plane_patch(a.x, a.y, b.x, b.y, c.x, c.y, values_[v[0]], values_[v[1]], values_[v[2]]);
        sums_[t] = {};
        batch.count = 0;
        for (const PixelRun& run : pixel_runs(t))
            for (int x = run.first; x < run.end; ++x) {
                if (batch.count == PixelBatch::kMost) flush(batch, patch, sums_[t]);
                batch.x[batch.count] = x;
                batch.y[batch.count] = run.y;
                batch.d[batch.count++] = view_.disparity[view_.index(x, run.y)];
            }
        flush(batch, patch, sums_[t]);
    }
    void relax() {
        next_.resize(values_.size());
        team_.for_ranges(values_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                double right = kPull * planes_[v];
                for (std::uint32_t i = corners_.starts[v]; i < corners_.starts[v + 1]; ++i) {
                    const Term& term = terms_[i];
                    right += step::right_side(term.row, values_[term.next], values_[term.last]);
                }
                next_[v] = step::clamp_to(values_[v] + kDamping * (right / diagonals_[v] - values_[v]),
                                          double(least_[v]), double(most_[v]));
            }
        });
        values_.swap(next_);
    }

    struct Term {
        step::CornerRow row;
        std::uint32_t next, last;  // the triangle's other vertices
    };

    step::PixelView view_;
    const std::vector<Vec2f>& points_;
    const std::vector<Triangle>& triangles_;
    const TriangleSides& sides_;
    const std::vector<std::uint32_t>& origins_;
    Buckets corners_;
    Team& team_;
    std::vector<double> values_, next_, planes_;  // disparities
    double floor_ = 0;                            // of all of them
    std::vector<float> least_, most_;             // bounds of them
    std::vector<step::TriangleSums> sums_;
    std::vector<Term> terms_;  // of each vertex' equation, as in corners_
    std::vector<double> diagonals_;
};

}  // namespace

std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const std::vector<Vec2f>& points,
                                   const std::vector<Triangle>& triangles, const TriangleSides& sides,
                                   const std::vector<std::uint32_t>& origins, Team& team) {
    return Fitter(surfaces, points, triangles, sides, origins, team).run();
}

}  // namespace hexrelief
