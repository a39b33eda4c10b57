#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>

#include "mesher/common/counting_sort.h"
#include "mesher/common/thread_pool.h"
#include "mesher/surface/fit/fit_disparities_simd.h"
#include "mesher/surface/fit/fit_disparities_step.h"
#include "mesher/surface/fit/full_sums_step.h"
#include "mesher/surface/pixels/half_occlusion_step.h"
#include "mesher/surface/topology/label_triangles.h"

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
    std::vector<std::uint32_t> least(static_cast<std::size_t>(pool.size()), ~0u);
    const std::size_t pixels = static_cast<std::size_t>(view.width) * view.height;
    pool.run([&](int thread) {
        // Bits of positive floats are in their order; less one, 0 comes last.
        std::uint32_t mine = ~0u;
        for (std::size_t i = pool.share(pixels, thread), end = pool.share(pixels, thread + 1); i < end; ++i)
            mine = std::min(mine, std::bit_cast<std::uint32_t>(view.disparity[i]) - 1);
        least[static_cast<std::size_t>(thread)] = mine;
    });
    const std::uint32_t bits = *std::min_element(least.begin(), least.end());
    const float most = std::numeric_limits<float>::max();
    return bits < std::bit_cast<std::uint32_t>(most) ? std::bit_cast<float>(bits + 1) : most;
}

class Fitter {
  public:
    Fitter(const PixelSurfaces& surfaces, const std::vector<Vec2f>& points,
           const std::vector<Triangle>& triangles, const TriangleLabels& sides,
           const std::vector<std::uint32_t>& source_triangles, ThreadPool& pool)
        : view_(surfaces.view()),
          points_(points),
          triangles_(triangles),
          sides_(sides),
          source_triangles_(source_triangles),
          pool_(pool),
          corners_(corners_of(triangles, points.size())),
          equations_(corners_, triangles, points.size(), pool),
          values_(equations_.values) {}

    std::vector<float> run() {
        floor_ = step::lowest_disparity(smallest_disparity(view_, pool_));
        start_from_planes();
        sums_.resize(triangles_.size());
        gather_sums();
        gather_terms();
        for (int sweep = 0; sweep < step::kFitSweeps; ++sweep) {
            pool_.parallel_for(equations_.blocks(),
                               [&](std::size_t first, std::size_t end) { equations_.relax(first, end); });
            values_.swap(equations_.relaxed);
        }
        return {values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(points_.size())};
    }

  private:
    static constexpr std::size_t kWeighedAtOnce = 64;  // triangles, at least

    std::span<const PixelRun> pixel_runs(std::size_t t) const { return sides_.fitted[source_triangles_[t]]; }

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
                equations_.least[v] = start.least;
                equations_.most[v] = start.most;
                values_[v] = equations_.planes[v] = start.disparity;
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
            values_[v] = std::max<double>(floor_, view_.disparity[sides_.anchors[source_triangles_[t]]]);
        }
        for (const std::size_t v : unknown) {
            equations_.planes[v] = values_[v];
            equations_.least[v] = equations_.most[v] = static_cast<float>(values_[v]);
        }
    }
    // The normal equations, weighted by how far pixels are from where the vertices begin. Most triangles'
    // follow from their moments.
    void gather_sums() {
        ThreadPool::ChunkCounters chunk_counters(pool_.size());
        pool_.run([&](int thread) {
            TriangleLanes lanes(view_);
            std::vector<std::pair<std::uint32_t, std::uint32_t>> left;  // pixels, triangle
            pool_.run_chunks(triangles_.size(), thread, chunk_counters,
                             [&](std::size_t first, std::size_t last) {
                                 for (std::size_t t = first; t < last; ++t) {
                                     const step::PlanePatch patch = patch_of(t);
                                     if (!behind_half_occlusion_[t] && step::all_fit(moments_[t], patch))
                                         sums_[t] = step::full_sums(moments_[t], patch);
                                     else
                                         left.emplace_back(static_cast<std::uint32_t>(moments_[t].n),
                                                           static_cast<std::uint32_t>(t));
                                 }
                                 if (left.size() >= kWeighedAtOnce) weigh(left, lanes);
                             });
            weigh(left, lanes);
        });
    }
    // Side by side those with as many pixels: lanes wait for the longest.
    void weigh(std::vector<std::pair<std::uint32_t, std::uint32_t>>& left, TriangleLanes& lanes) {
        std::sort(left.begin(), left.end());
        for (const auto& [pixels, t] : left) {
            lanes.add(patch_of(t), pixel_runs(t), sums_[t]);
            if (lanes.full()) lanes.weigh();
        }
        lanes.weigh();
        left.clear();
    }
    step::PlanePatch patch_of(std::size_t t) const {
        const Triangle& v = triangles_[t];
        const Vec2f &a = points_[v[0]], &b = points_[v[1]], &c = points_[v[2]];
        return step::plane_patch(a.x, a.y, b.x, b.y, c.x, c.y, values_[v[0]], values_[v[1]], values_[v[2]]);
    }
    // Of each vertex, what a sweep needs of them.
    void gather_terms() {
        pool_.parallel_for_chunks(points_.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                std::size_t at = std::size_t{equations_.starts[v / kFitLanes]} * kFitLanes + v % kFitLanes;
                double diagonal = step::kFitPull;
                for (const std::uint32_t i : corners_[v]) {
                    const step::CornerRow row = step::corner_row(sums_[i / 3], i % 3);
                    diagonal += row.own;
                    equations_.row_next[at] = row.next;
                    equations_.row_last[at] = row.last;
                    equations_.row_right[at] = row.right;
                    at += kFitLanes;
                }
                equations_.diagonals[v] = diagonal;
            }
        });
    }

    step::PixelView view_;
    const std::vector<Vec2f>& points_;
    const std::vector<Triangle>& triangles_;
    const TriangleLabels& sides_;
    const std::vector<std::uint32_t>& source_triangles_;
    ThreadPool& pool_;
    Buckets corners_;
    VertexLanes equations_;
    RawVector<double>& values_;  // disparities
    double floor_ = 0;           // of all of them
    // Of triangles: their pixels', whether one of these is behind a low half-occlusion step, and their sums.
    RawVector<step::Moments> moments_;
    RawVector<std::uint8_t> behind_half_occlusion_;
    RawVector<step::TriangleSums> sums_;
};

}  // namespace

std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const std::vector<Vec2f>& points,
                                   const std::vector<Triangle>& triangles, const TriangleLabels& sides,
                                   const std::vector<std::uint32_t>& source_triangles, ThreadPool& pool) {
    return Fitter(surfaces, points, triangles, sides, source_triangles, pool).run();
}

}  // namespace hexrelief
