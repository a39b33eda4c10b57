#include "mesher/surface/fit/fit_disparities.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "mesher/common/counting_sort.h"
#include "mesher/common/thread_pool.h"
#include "mesher/surface/fit/fit_disparities_step.h"
#include "mesher/surface/fit/fit_weight_step.h"
#include "mesher/surface/fit/full_sums_step.h"
#include "mesher/surface/pixels/half_occlusion_step.h"

namespace hexrelief {
namespace {

// Of each vertex: 3 * triangle + corner, ascending.
Buckets corners_of(const std::vector<Triangle>& triangles, std::size_t vertices) {
    return sort_into(vertices, [&](const auto& put) {
        std::uint32_t i = 0;
        for (const Triangle& t : triangles)
            for (const std::uint32_t v : t) put(v, i++);
    });
}

// Of the disparities above 0; the largest float where there are none.
float smallest_disparity(const step::PixelView& view, ThreadPool& pool) {
    std::vector<float> smallest(static_cast<std::size_t>(pool.size()));
    const std::size_t pixels = static_cast<std::size_t>(view.width) * view.height;
    pool.run([&](int thread) {
        float own = std::numeric_limits<float>::max();
        for (std::size_t i = pool.share(pixels, thread), end = pool.share(pixels, thread + 1); i < end; ++i)
            if (view.disparity[i] > 0) own = std::min(own, view.disparity[i]);
        smallest[static_cast<std::size_t>(thread)] = own;
    });
    return *std::min_element(smallest.begin(), smallest.end());
}

class Fitter {
  public:
    Fitter(const PixelSurfaces& surfaces, const TriangleLabels& labels, const CutTriangles& cut,
           ThreadPool& pool)
        : view_(surfaces.view()),
          points_(cut.points),
          triangles_(cut.triangles),
          labels_(labels),
          source_triangles_(cut.source_triangles),
          pool_(pool),
          corners_(corners_of(triangles_, points_.size())),
          equations_(points_.size()),
          values_(points_.size(), 0) {}

    std::vector<float> run() {
        floor_ = step::lowest_disparity(smallest_disparity(view_, pool_));
        start_from_planes();
        sums_.resize(triangles_.size());
        gather_sums();
        gather_terms();
        std::vector<double> next(values_.size());
        for (int sweep = 0; sweep < step::kFitSweeps; ++sweep) {
            pool_.parallel_for(values_.size(), [&](std::size_t first, std::size_t end) {
                for (std::size_t v = first; v < end; ++v) next[v] = relaxed(v);
            });
            values_.swap(next);
        }
        return {values_.begin(), values_.end()};
    }

  private:
    // A vertex's normal equation but for its terms.
    struct Equation {
        double diagonal = 1, plane = 0;  // of the unknown; the disparity that it is pulled to
        float least = 0, most = 0;       // bounds of the solution
    };
    // What a triangle adds to the equation of one of its vertices: its row, and its other two vertices.
    struct Term {
        step::CornerRow row;
        std::uint32_t next, last;
    };

    std::span<const PixelRun> pixel_runs(std::size_t t) const { return labels_.fitted[source_triangles_[t]]; }

    // Calls visit(triangle) for the triangles at v and, in the second ring, at their other vertices.
    template <typename Visit>
    void each_triangle(std::size_t v, bool second_ring, const Visit& visit) const {
        for (const std::uint32_t i : corners_[v]) {
            if (!second_ring) {
                visit(i / 3);
                continue;
            }
            for (const std::uint32_t u : triangles_[i / 3])
                for (const std::uint32_t j : corners_[u]) visit(j / 3);
        }
    }
    bool has_behind_half_occlusion(const PixelRun& run) const {
        if (!step::has_discontinuity_before(view_, run.y, run.first, run.end)) return false;
        for (int x = run.first; x < run.end; ++x)
            if (step::is_behind_low_half_occlusion(view_, x, run.y)) return true;
        return false;
    }
    void start_from_planes() {
        moments_.resize(triangles_.size());
        behind_half_occlusion_.resize(triangles_.size());
        pool_.parallel_for_chunks(triangles_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t t = first; t < last; ++t) {
                step::Moments sum;  // in registers
                bool behind_half_occlusion = false;
                for (const PixelRun& run : pixel_runs(t)) {
                    step::add_run(sum, run.y, run.first, run.end);
                    const float* const row = view_.disparity + view_.index(0, run.y);
                    for (int x = run.first; x < run.end; ++x) step::add_disparity(sum, x, run.y, row[x]);
                    behind_half_occlusion = behind_half_occlusion || has_behind_half_occlusion(run);
                }
                moments_[t] = sum;
                behind_half_occlusion_[t] = behind_half_occlusion;
            }
        });
        std::vector<std::uint8_t> known(points_.size(), 0);
        pool_.parallel_for_chunks(points_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                step::Moments sum;
                each_triangle(v, false, [&](std::uint32_t t) { step::add_moments(sum, moments_[t]); });
                if (!step::holds_plane(sum)) {
                    sum = {};
                    each_triangle(v, true, [&](std::uint32_t t) { step::add_moments(sum, moments_[t]); });
                }
                if (!(sum.n > 0)) continue;
                const step::FitStart start = step::fit_start(sum, points_[v], longest_edge(v), floor_);
                equations_[v].least = start.least;
                equations_[v].most = start.most;
                values_[v] = equations_[v].plane = start.disparity;
                known[v] = 1;
            }
        });
        fill_unknown(known);
    }
    float longest_edge(std::size_t v) const {
        float longest = 0;
        each_triangle(v, false, [&](std::uint32_t t) {
            for (const std::uint32_t u : triangles_[t])
                longest = std::max(longest, step::squared_length(points_[v], points_[u]));
        });
        return std::sqrt(longest);
    }
    // Vertices far from any pixel that counts (all speckles) stay where they begin: at the mean of their
    // neighbours, ring by ring; where a whole component has none, at its triangles' own surface.
    void fill_unknown(std::vector<std::uint8_t>& known) {
        std::vector<std::size_t> unknown;
        for (std::size_t v = 0; v < known.size(); ++v)
            if (!known[v]) unknown.push_back(v);
        std::vector<std::size_t> left = unknown;
        for (bool moved = true; moved;) {
            std::vector<std::pair<std::size_t, double>> found;
            for (const std::size_t v : left) {
                double sum = 0;
                int count = 0;
                each_triangle(v, false, [&](std::uint32_t t) {
                    for (const std::uint32_t u : triangles_[t])
                        if (known[u]) sum += values_[u], ++count;
                });
                if (count > 0) found.emplace_back(v, sum / count);
            }
            for (const auto& [v, value] : found) values_[v] = value, known[v] = 1;
            std::erase_if(left, [&](std::size_t v) { return known[v]; });
            moved = !found.empty();
        }
        for (const std::size_t v : left) {
            const std::uint32_t t = corners_[v].front() / 3;
            values_[v] = std::max<double>(floor_, view_.disparity[labels_.anchors[source_triangles_[t]]]);
        }
        for (const std::size_t v : unknown) {
            equations_[v].plane = values_[v];
            equations_[v].least = equations_[v].most = static_cast<float>(values_[v]);
        }
    }
    // The normal equations, weighted by how far pixels are from where the vertices begin. Most triangles'
    // follow from their moments.
    void gather_sums() {
        pool_.parallel_for_chunks(triangles_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t t = first; t < last; ++t) {
                const step::PlanePatch patch = patch_of(t);
                const bool all_count = !behind_half_occlusion_[t] && step::all_fit(moments_[t], patch);
                sums_[t] = all_count ? step::full_sums(moments_[t], patch) : weighted_sums(t, patch);
            }
        });
    }
    step::TriangleSums weighted_sums(std::size_t t, const step::PlanePatch& patch) const {
        step::TriangleSums sums;
        for (const PixelRun& run : pixel_runs(t)) {
            const float* const row = view_.disparity + view_.index(0, run.y);
            const bool near_half_occlusion = step::has_discontinuity_before(view_, run.y, run.first, run.end);
            for (int x = run.first; x < run.end; ++x) {
                double l1, l2;
                const double residual = step::pixel_residual(patch, x, run.y, row[x], l1, l2);
                const bool behind =
                    near_half_occlusion && step::is_behind_low_half_occlusion(view_, x, run.y);
                step::add_pixel(sums, 1 - l1 - l2, l1, l2, row[x], step::fit_weight(residual, behind));
            }
        }
        return sums;
    }
    step::PlanePatch patch_of(std::size_t t) const {
        const Triangle& v = triangles_[t];
        const Vec2f &a = points_[v[0]], &b = points_[v[1]], &c = points_[v[2]];
        return step::plane_patch(a.x, a.y, b.x, b.y, c.x, c.y, values_[v[0]], values_[v[1]], values_[v[2]]);
    }
    // Of each vertex, what a sweep needs of them.
    void gather_terms() {
        terms_.resize(corners_.items.size());
        pool_.parallel_for_chunks(points_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                std::size_t at = corners_.starts[v];
                double diagonal = step::kFitPlaneWeight;
                for (const std::uint32_t i : corners_[v]) {
                    const Triangle& t = triangles_[i / 3];
                    const std::uint32_t k = i % 3;
                    const step::CornerRow row = step::corner_row(sums_[i / 3], k);
                    diagonal += row.own;
                    terms_[at++] = {row, t[(k + 1) % 3], t[(k + 2) % 3]};
                }
                equations_[v].diagonal = diagonal;
            }
        });
    }
    // The vertex's disparity after a sweep.
    double relaxed(std::size_t v) const {
        const Equation& e = equations_[v];
        double right = step::kFitPlaneWeight * e.plane;
        for (std::size_t i = corners_.starts[v]; i < corners_.starts[v + 1]; ++i) {
            const Term& term = terms_[i];
            right += step::right_side(term.row, values_[term.next], values_[term.last]);
        }
        return step::relaxed(values_[v], right, e.diagonal, e.least, e.most);
    }

    step::PixelView view_;
    const std::vector<Vec2f>& points_;
    const std::vector<Triangle>& triangles_;
    const TriangleLabels& labels_;
    const std::vector<std::uint32_t>& source_triangles_;
    ThreadPool& pool_;
    Buckets corners_;
    std::vector<Equation> equations_;  // of vertices
    RawVector<Term> terms_;            // of vertices' corners, as in corners_
    std::vector<double> values_;       // of vertices: disparities
    double floor_ = 0;                 // of all of them
    // Of triangles: their pixels', whether one of these is behind a low half-occlusion step, and their sums.
    RawVector<step::Moments> moments_;
    RawVector<std::uint8_t> behind_half_occlusion_;
    RawVector<step::TriangleSums> sums_;
};

}  // namespace

std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const TriangleLabels& labels,
                                   const CutTriangles& cut, ThreadPool& pool) {
    return Fitter(surfaces, labels, cut, pool).run();
}

}  // namespace hexrelief
