#include "mesher/surface/fit/silhouette_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "mesher/common/simd.h"
#include "mesher/common/simd_bytes.h"

namespace hexrelief {
namespace {

constexpr int K = kSampleLanes;

// Writes what the edge sees of sides.
HEXRELIEF_VECTORS void see(const step::SilhouetteEdgeFrame& edge, const float* __restrict sides, int count,
                           float* __restrict shares, float* __restrict residuals, float* __restrict weights,
                           float* __restrict acrosses) {
    const step::SilhouetteEdgeFrame e = edge;
    for (int first = 0; first < count; first += K)
        for (int k = 0; k < K; ++k) {
            const int i = first + k;
            const step::SilhouettePull pull = step::silhouette_pull(
                e, {sides[i], sides[count + i], sides[2 * count + i], sides[3 * count + i]});
            shares[i] = pull.share;
            residuals[i] = pull.residual;
            weights[i] = pull.weight;
            acrosses[i] = pull.across;
        }
}

}  // namespace

SilhouetteSamples SilhouetteSampler::find(const Vec2f& p, const Vec2f& q, float reach_px) {
    const step::PixelBox box = step::pixels_around(view_, p, q, reach_px);
    const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
    const float around = reach_px + 0.01f;  // more than rounding may do
    const float most = around * around * size2;
    // along the edge, as shares of its squared size
    const float before = -around * std::sqrt(size2), beyond = size2 - before;
    const std::uint8_t* const end = view_.flags + view_.index(0, view_.height);
    std::size_t count = 0;
    for (int y = box.y0; y <= box.y1; ++y)
        for (int x0 = box.x0; x0 <= box.x1; x0 += 8) {
            std::uint64_t discontinuities =
                eight_at(view_.flags + view_.index(x0, y), end) &
                lanes_of(static_cast<std::size_t>(box.x1 - x0 + 1)) &
                in_each_lane(step::kDiscontinuityRight | step::kDiscontinuityDown);
            if (discontinuities == 0) continue;
            if (count + 16 + K > x_.size())
                for (std::vector<float>* v : {&x_, &y_, &near_x_, &near_y_}) v->resize(2 * (count + 16 + K));
            for (; discontinuities != 0; discontinuities &= discontinuities - 1) {
                const int bit = std::countr_zero(discontinuities);
                const step::SilhouetteSample side =
                    step::silhouette_sample(view_, {x0 + bit / 8, y, bit % 8});
                const float mx = side.x - p.x, my = side.y - p.y;
                const float off = my * dx - mx * dy, along = mx * dx + my * dy;
                x_[count] = side.x;
                y_[count] = side.y;
                near_x_[count] = side.near_x;
                near_y_[count] = side.near_y;
                // no branch, which could not be foreseen
                count += (off * off <= most) & (along >= before) & (along <= beyond);
            }
        }
    if (count == 0) return {};
    const std::size_t whole = (count + K - 1) / K * K;
    float* const room = found_.room_for(4 * whole);
    const std::vector<float>* const from[4] = {&x_, &y_, &near_x_, &near_y_};
    for (std::size_t i = 0; i < 4; ++i) {
        std::copy_n(from[i]->data(), count, room + i * whole);
        const float none = i == 0 ? p.x : i == 1 ? p.y : 0;
        std::fill_n(room + i * whole + count, whole - count, none);
    }
    return {room, static_cast<int>(whole)};
}

step::SilhouettePulls SilhouetteSampler::pulls(const step::SilhouetteEdgeFrame& edge,
                                               const SilhouetteSamples& sides) {
    const std::size_t count = static_cast<std::size_t>(sides.count);
    if (shares_.size() < count) {
        for (std::vector<float>* v : {&shares_, &residuals_, &weights_, &acrosses_}) v->resize(2 * count);
        weighing_.resize(2 * count);
    }
    float *const shares = shares_.data(), *const residuals = residuals_.data(),
                 *const weights = weights_.data(), *const acrosses = acrosses_.data();
    see(edge, sides.values, sides.count, shares, residuals, weights, acrosses);
    // Most weigh nothing, and add nothing.
    std::uint32_t* const weighing = weighing_.data();
    std::size_t some = 0;
    for (std::size_t i = 0; i < count; ++i) {
        weighing[some] = static_cast<std::uint32_t>(i);
        some += weights[i] != 0;
    }
    double facing = 0;
    for (std::size_t k = 0; k < some; ++k) facing += weights[weighing[k]] * acrosses[weighing[k]];
    step::SilhouettePulls sums{};
    for (std::size_t k = 0; k < some; ++k) {
        const std::size_t i = weighing[k];
        step::add_pull(sums, {shares[i], residuals[i], weights[i], acrosses[i]}, facing);
    }
    return sums;
}

}  // namespace hexrelief
