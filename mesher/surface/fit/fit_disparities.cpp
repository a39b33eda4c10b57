#include "mesher/surface/fit/fit_disparities.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>

#include "mesher/surface/fit/fit_disparities_step.h"
#include "mesher/surface/fit/full_sums_step.h"
#include "mesher/surface/pixels/half_occlusion_step.h"
#include "pipeline/base/simd.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/counting_sort.h"

namespace hexrelief::surface {
namespace {

// Returns for each vertex its corners as 3 * triangle + corner, ascending.
Buckets corners_of(const std::vector<Triangle>& triangles, std::size_t vertices) {
    return sort_into(vertices, [&](const auto& put) {
        std::uint32_t i = 0;
        for (const Triangle& t : triangles)
            for (const std::uint32_t v : t) put(v, i++);
    });
}

// Returns the smallest disparity above 0; the largest float if there is none. Non-negative floats have the
// order of their bits, whose minimum vectorises; subtracting 1 makes a 0 wrap around to the largest number.
HEXRELIEF_VECTORS float smallest_disparity(const float* disparity, std::size_t count) {
    std::uint32_t least = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::max()) - 1;
    for (std::size_t i = 0; i < count; ++i)
        least = std::min(least, std::bit_cast<std::uint32_t>(disparity[i]) - 1);
    return std::bit_cast<float>(least + 1);
}

float smallest_disparity(const step::PixelView& view, ThreadPool& pool) {
    std::vector<float> smallest(static_cast<std::size_t>(pool.size()));
    const std::size_t pixels = static_cast<std::size_t>(view.width) * view.height;
    pool.run([&](int thread) {
        const std::size_t first = pool.share(pixels, thread), end = pool.share(pixels, thread + 1);
        smallest[static_cast<std::size_t>(thread)] = smallest_disparity(view.disparity + first, end - first);
    });
    return *std::min_element(smallest.begin(), smallest.end());
}

class Fitter {
  public:
    Fitter(const PixelSurfaces& surfaces, const TriangleLabels& labels, const CutTriangles& cut,
           float farthest_px, ThreadPool& pool)
        : view_(surfaces.view()),
          tiles_(surfaces.tiles()),
          points_(cut.points),
          triangles_(cut.triangles),
          labels_(labels),
          source_triangles_(cut.source_triangles),
          farthest_px_(farthest_px),
          pool_(pool),
          corners_(corners_of(triangles_, points_.size())),
          equations_(points_.size()),
          values_(points_.size(), 0) {}

    std::vector<float> run() {
        const float smallest = smallest_disparity(view_, pool_);
        floor_ = step::lowest_disparity(farthest_px_ > 0 ? std::min(farthest_px_, smallest) : smallest);
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
    // A vertex's normal equation except for its terms.
    struct Equation {
        double diagonal = 1, plane = 0;  // coefficient of the unknown; disparity of the vertex's own plane
    };
    // A triangle's contribution to the equation of one of its vertices: its row, and its other two vertices.
    struct Term {
        step::CornerRow row;
        std::uint32_t next, last;
    };

    std::span<const PixelRun> pixel_runs(std::size_t t) const { return labels_.fitted[source_triangles_[t]]; }

    // Fits a plane to the pixels around each vertex, for its start value.
    void start_from_planes() {
        moments_.resize(triangles_.size());
        pool_.parallel_for_chunks(triangles_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t t = first; t < last; ++t) {
                step::Moments sum;  // kept in registers
                for (const PixelRun& run : pixel_runs(t)) {
                    step::add_run(sum, run.y, run.first, run.end);
                    const float* const row = view_.disparity + view_.index(0, run.y);
                    for (int x = run.first; x < run.end; ++x) step::add_disparity(sum, x, run.y, row[x]);
                }
                moments_[t] = sum;
            }
        });
        pool_.parallel_for_chunks(points_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                step::Moments sum;
                for (const std::uint32_t i : corners_[v]) step::add_moments(sum, moments_[i / 3]);
                // without pixels (all belong to speckles) start at a triangle's own surface
                const std::uint32_t anchor = labels_.anchors[source_triangles_[corners_[v].front() / 3]];
                const double start =
                    sum.n > 0 ? step::plane_at(sum, points_[v].x, points_[v].y) : view_.disparity[anchor];
                values_[v] = equations_[v].plane = std::max(floor_, start);
            }
        });
    }
    // Sets up each triangle's normal equations; those of most triangles follow from their moments.
    void gather_sums() {
        pool_.parallel_for_chunks(triangles_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t t = first; t < last; ++t) {
                const Triangle& v = triangles_[t];
                const Vec2f &a = points_[v[0]], &b = points_[v[1]], &c = points_[v[2]];
                const step::PlanePatch patch = step::plane_patch(a.x, a.y, b.x, b.y, c.x, c.y);
                sums_[t] = step::holds_sums(patch) && !is_behind_half_occlusion(t)
                               ? step::full_sums(moments_[t], patch)
                               : weighted_sums(t, patch);
            }
        });
    }
    // True if one of the triangle's pixels lies behind a low half-occlusion step.
    bool is_behind_half_occlusion(std::size_t t) const {
        const std::span<const PixelRun> runs = pixel_runs(t);
        if (runs.empty()) return false;
        int first = view_.width - 1, last = 0;
        for (const PixelRun& run : runs)
            first = std::min(first, run.first), last = std::max(last, run.end - 1);
        first = std::max(0, first - step::kHalfOcclusionReach_px);
        if (!step::tiles_hold(tiles_, first, runs.front().y, last, runs.back().y)) return false;
        for (const PixelRun& run : runs) {
            if (!step::has_discontinuity_before(view_, run.y, run.first, run.end)) continue;
            for (int x = run.first; x < run.end; ++x)
                if (step::is_behind_low_half_occlusion(view_, x, run.y)) return true;
        }
        return false;
    }
    // Returns a triangle's sums over its weighted pixels.
    step::TriangleSums weighted_sums(std::size_t t, const step::PlanePatch& patch) const {
        step::TriangleSums sums;
        for (const PixelRun& run : pixel_runs(t))
            for (int x = run.first; x < run.end; ++x) {
                double l1, l2;
                step::pixel_shares(patch, x, run.y, l1, l2);
                step::add_pixel(sums, 1 - l1 - l2, l1, l2, view_.disparity[view_.index(x, run.y)],
                                step::fit_weight(view_, x, run.y));
            }
        return sums;
    }
    // Collects for each vertex the terms that a sweep needs, and the coefficient of the unknown.
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
    // Returns the vertex's disparity after a sweep.
    double relaxed(std::size_t v) const {
        const Equation& e = equations_[v];
        double right = step::kFitPlaneWeight * e.plane;
        for (std::size_t i = corners_.starts[v]; i < corners_.starts[v + 1]; ++i) {
            const Term& term = terms_[i];
            right += step::right_side(term.row, values_[term.next], values_[term.last]);
        }
        return step::relaxed(values_[v], right, e.diagonal, floor_);
    }

    step::PixelView view_;
    step::TileView tiles_;
    const std::vector<Vec2f>& points_;
    const std::vector<Triangle>& triangles_;
    const TriangleLabels& labels_;
    const std::vector<std::uint32_t>& source_triangles_;
    float farthest_px_;
    ThreadPool& pool_;
    Buckets corners_;
    std::vector<Equation> equations_;  // per vertex
    RawVector<Term> terms_;            // per corner of a vertex, as in corners_
    std::vector<double> values_;       // per vertex: its disparity
    double floor_ = 0;                 // least disparity of a vertex
    // Per triangle: its pixels' moments, and its sums.
    RawVector<step::Moments> moments_;
    RawVector<step::TriangleSums> sums_;
};

}  // namespace

std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const TriangleLabels& labels,
                                   const CutTriangles& cut, float farthest_px, ThreadPool& pool) {
    return Fitter(surfaces, labels, cut, farthest_px, pool).run();
}

}  // namespace hexrelief::surface
