#include "mesher/surface/fit/fit_disparities_simd.h"

#include <algorithm>

#include "mesher/common/simd.h"
#include "mesher/surface/pixels/half_occlusion_step.h"

namespace hexrelief {
namespace {

constexpr int K = kFitLanes;

// Adds up to `pixels` of each lane. Returns nothing new for lanes whose weight is 0 throughout.
struct LaneView {
    const double *x, *y, *abx, *aby, *acx, *acy, *area, *d0, *d1, *d2, *count;
    const double (*column)[K], (*row)[K], (*disparity)[K], (*weight)[K];
    double (*sums)[K];
};

HEXRELIEF_VECTORS void add_pixels(const LaneView& lanes, int pixels) {
    double sums[9][K];
    for (int j = 0; j < 9; ++j)
        for (int k = 0; k < K; ++k) sums[j][k] = lanes.sums[j][k];
    for (int i = 0; i < pixels; ++i) {
        double l1[K], l2[K], weight[K], size[K];
        for (int k = 0; k < K; ++k) {
            const step::PlanePatch patch{lanes.x[k],   lanes.y[k],   lanes.abx[k],  lanes.aby[k],
                                         lanes.acx[k], lanes.acy[k], lanes.area[k], lanes.d0[k],
                                         lanes.d1[k],  lanes.d2[k]};
            const double residual = step::pixel_residual(patch, lanes.column[i][k], lanes.row[i][k],
                                                         lanes.disparity[i][k], l1[k], l2[k]);
            size[k] = residual < 0 ? -residual : residual;
        }
        int beyond = 0;
        for (int k = 0; k < K; ++k) beyond |= size[k] > step::kFitTolerance_px;
        for (int k = 0; k < K; ++k) weight[k] = lanes.weight[i][k];
        if (beyond)  // rare, and its division dear
            for (int k = 0; k < K; ++k) weight[k] = step::fit_weight(size[k], weight[k] > 1);
        for (int k = 0; k < K; ++k) {
            const double w = i < lanes.count[k] ? weight[k] : 0.0;
            const double l0 = 1 - l1[k] - l2[k], d = lanes.disparity[i][k];
            step::TriangleSums s{{sums[0][k], sums[1][k], sums[2][k]},
                                 {sums[3][k], sums[4][k], sums[5][k]},
                                 {sums[6][k], sums[7][k], sums[8][k]}};
            step::add_pixel(s, l0, l1[k], l2[k], d, w);
            for (int j = 0; j < 3; ++j)
                sums[j][k] = s.own[j], sums[3 + j][k] = s.straddling[j], sums[6 + j][k] = s.right[j];
        }
    }
    for (int j = 0; j < 9; ++j)
        for (int k = 0; k < K; ++k) lanes.sums[j][k] = sums[j][k];
}

HEXRELIEF_VECTORS void relax_block(int slots, const double* __restrict row_next,
                                   const double* __restrict row_last, const double* __restrict row_right,
                                   const std::int32_t* __restrict next, const std::int32_t* __restrict last,
                                   const double* __restrict planes, const double* __restrict diagonals,
                                   const float* __restrict least, const float* __restrict most,
                                   const double* __restrict values, const double* __restrict own,
                                   double* __restrict out) {
    double right[K];
    for (int k = 0; k < K; ++k) right[k] = step::kFitPull * planes[k];
    for (int i = 0; i < slots; ++i, row_next += K, row_last += K, row_right += K, next += K, last += K)
        for (int k = 0; k < K; ++k)
            right[k] += step::right_side({0, row_next[k], row_last[k], row_right[k]}, values[next[k]],
                                         values[last[k]]);
    for (int k = 0; k < K; ++k) out[k] = step::relaxed(own[k], right[k], diagonals[k], least[k], most[k]);
}

}  // namespace

void TriangleLanes::add(const step::PlanePatch& p, std::span<const PixelRun> runs, step::TriangleSums& sums) {
    const int k = used_++;
    const PixelRun* const first = runs.data();
    lanes_[k] = {first, first + runs.size(), runs.empty() ? 0 : first->first, &sums};
    x_[k] = p.x, y_[k] = p.y, abx_[k] = p.abx, aby_[k] = p.aby, acx_[k] = p.acx, acy_[k] = p.acy;
    area_[k] = p.area, d0_[k] = p.d0, d1_[k] = p.d1, d2_[k] = p.d2;
}

// The next pixels of each lane; returns the most of any. Lanes with fewer repeat one, at no weight.
int TriangleLanes::fill() {
    int most = 0, counts[K];
    for (int k = 0; k < used_; ++k) {
        Lane& lane = lanes_[k];
        int count = 0;
        while (lane.run != lane.end && count < kMost_px) {
            const PixelRun& run = *lane.run;
            const int end = std::min(run.end, lane.next + kMost_px - count);
            const float* const row = view_.disparity + view_.index(0, run.y);
            const bool near_half_occlusion = step::has_discontinuity_before(view_, run.y, lane.next, end);
            for (int x = lane.next; x < end; ++x, ++count) {
                column_[count][k] = x;
                row_[count][k] = run.y;
                disparity_[count][k] = row[x];
                weight_[count][k] = step::fit_weight(
                    0, near_half_occlusion && step::is_behind_low_half_occlusion(view_, x, run.y));
            }
            lane.next = end;
            if (end == run.end && ++lane.run != lane.end) lane.next = lane.run->first;
        }
        counts[k] = count;
        pixels_[k] = count;
        most = std::max(most, count);
    }
    for (int k = 0; k < used_; ++k)
        for (int i = std::max(counts[k], 1); i < most; ++i) {
            column_[i][k] = column_[0][k];
            row_[i][k] = row_[0][k];
            disparity_[i][k] = disparity_[0][k];
            weight_[i][k] = 1;
        }
    return most;
}

void TriangleLanes::weigh() {
    for (int k = 0; k < K; ++k) {
        for (auto& sum : sums_) sum[k] = 0;
        column_[0][k] = row_[0][k] = disparity_[0][k] = weight_[0][k] = 0;
        const bool any = k < used_ && lanes_[k].run != lanes_[k].end;
        if (any) continue;
        area_[k] = 1, pixels_[k] = 0;  // nothing is added, and nothing must become infinite
        if (k >= used_) x_[k] = y_[k] = abx_[k] = aby_[k] = acx_[k] = acy_[k] = d0_[k] = d1_[k] = d2_[k] = 0;
    }
    const LaneView view{x_,  y_,  abx_,    aby_,    acx_, acy_,       area_,   d0_,
                        d1_, d2_, pixels_, column_, row_, disparity_, weight_, sums_};
    while (const int pixels = fill()) add_pixels(view, pixels);
    for (int k = 0; k < used_; ++k) {
        for (int j = 0; j < 3; ++j) {
            lanes_[k].sums->own[j] = sums_[j][k];
            lanes_[k].sums->straddling[j] = sums_[3 + j][k];
            lanes_[k].sums->right[j] = sums_[6 + j][k];
        }
    }
    used_ = 0;
}

VertexLanes::VertexLanes(const Buckets& corners, const std::vector<Triangle>& triangles, std::size_t vertices,
                         ThreadPool& pool) {
    const std::size_t blocks = (vertices + K - 1) / K;
    starts.assign(blocks + 1, 0);
    for (std::size_t v = 0; v < vertices; ++v)
        starts[v / K + 1] = std::max(starts[v / K + 1], corners.starts[v + 1] - corners.starts[v]);
    for (std::size_t b = 0; b < blocks; ++b) starts[b + 1] += starts[b];
    const std::size_t slots = std::size_t{starts[blocks]} * K;
    for (RawVector<double>* each : {&row_next, &row_last, &row_right}) each->resize(slots);
    for (RawVector<std::int32_t>* each : {&next, &last}) each->resize(slots);
    for (RawVector<double>* each : {&diagonals, &planes, &values, &relaxed}) each->resize(blocks * K);
    for (RawVector<float>* each : {&least, &most}) each->resize(blocks * K);
    const auto fill = [&](std::size_t v, std::size_t end) {
        std::size_t at = std::size_t{starts[v / K]} * K + v % K;
        const auto room = v < vertices ? corners[v] : std::span<const std::uint32_t>();
        for (const std::uint32_t corner : room) {
            const Triangle& t = triangles[corner / 3];
            const std::uint32_t k = corner % 3;
            next[at] = static_cast<std::int32_t>(t[k == 2 ? 0 : k + 1]);
            last[at] = static_cast<std::int32_t>(t[k == 0 ? 2 : k - 1]);
            at += K;
        }
        for (; at < end; at += K) {  // without terms
            row_next[at] = row_last[at] = row_right[at] = 0;
            next[at] = last[at] = 0;
        }
    };
    pool.parallel_for(blocks, [&](std::size_t first, std::size_t last_block) {
        for (std::size_t b = first; b < last_block; ++b)
            for (std::size_t v = b * K; v < (b + 1) * K; ++v) {
                diagonals[v] = 1;
                planes[v] = values[v] = relaxed[v] = 0;
                least[v] = most[v] = 0;
                fill(v, std::size_t{starts[b + 1]} * K);
            }
    });
}

void VertexLanes::relax(std::size_t first, std::size_t end) {
    for (std::size_t b = first; b < end; ++b) {
        const std::size_t at = std::size_t{starts[b]} * K, v = b * K;
        relax_block(static_cast<int>(starts[b + 1] - starts[b]), &row_next[at], &row_last[at], &row_right[at],
                    &next[at], &last[at], &planes[v], &diagonals[v], &least[v], &most[v], values.data(),
                    &values[v], &relaxed[v]);
    }
}

}  // namespace hexrelief
