#include "mesher/surface/fit/silhouette_samples.h"

#include <cmath>
#include <span>

#include "mesher/surface/pixels/eight_flags.h"
#include "pipeline/base/simd.h"

namespace hexrelief::surface {
namespace {

// Writes share, residual, weight and across of all samples, one array after the other.
HEXRELIEF_VECTORS void find_residuals(const step::SilhouetteEdgeFrame& edge, const float* __restrict samples,
                                      int count, float* __restrict residuals) {
    const step::SilhouetteEdgeFrame e = edge;
    for (int first = 0; first < count; first += kSamplesAtOnce)
        for (int i = first; i < first + kSamplesAtOnce; ++i) {
            const step::SilhouetteResidual residual = step::silhouette_residual(
                e, {samples[i], samples[count + i], samples[2 * count + i], samples[3 * count + i]});
            residuals[i] = residual.share;
            residuals[count + i] = residual.residual;
            residuals[2 * count + i] = residual.weight;
            residuals[3 * count + i] = residual.across;
        }
}

}  // namespace

SilhouetteSamples SilhouetteSampler::find(const Vec2f& p, const Vec2f& q, float reach_px) {
    const step::PixelBox box = step::pixels_around(view_, p, q, reach_px);
    const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
    const float around = reach_px + step::kRounding_px;
    const float most = around * around * size2;
    // along the edge, multiplied by its length
    const float before = -around * std::sqrt(size2), beyond = size2 - before;
    buffer_.clear();
    for (int y = box.y0; y <= box.y1; ++y)
        each_crack(view_, y, box.x0, box.x1 + 1, [&](const step::Crack& c) {
            const step::SilhouetteSample sample = step::silhouette_sample(view_, c);
            const float mx = sample.x - p.x, my = sample.y - p.y;
            const float off = my * dx - mx * dy, along = mx * dx + my * dy;
            if (off * off <= most && along >= before && along <= beyond) buffer_.push_back(sample);
        });
    const std::size_t count = (buffer_.size() + kSamplesAtOnce - 1) / kSamplesAtOnce * kSamplesAtOnce;
    buffer_.resize(count, {0, 0, 0, 0});
    float* const values = found_.allocate(4 * count);
    for (std::size_t i = 0; i < count; ++i) {
        values[i] = buffer_[i].x;
        values[count + i] = buffer_[i].y;
        values[2 * count + i] = buffer_[i].near_x;
        values[3 * count + i] = buffer_[i].near_y;
    }
    return {values, static_cast<int>(count)};
}

step::SilhouetteResiduals SilhouetteSampler::residuals(const step::SilhouetteEdgeFrame& edge,
                                                       const SilhouetteSamples& samples) {
    const std::size_t size = static_cast<std::size_t>(samples.count);
    if (weighing_.size() < size) {
        weighing_.resize(2 * size);
        residuals_.resize(8 * size);
    }
    find_residuals(edge, samples.values, samples.count, residuals_.data());
    const float *const shares = residuals_.data(), *const residuals = shares + size,
                       *const weights = residuals + size, *const acrosses = weights + size;
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < size; ++i) {  // without a branch, which would be unpredictable
        weighing_[count] = i;
        count += weights[i] != 0;
    }
    double facing = 0;
    const std::span<const std::uint32_t> weighing(weighing_.data(), count);
    for (const std::uint32_t i : weighing) facing += weights[i] * acrosses[i];
    step::SilhouetteResiduals sums{};
    for (const std::uint32_t i : weighing)
        step::add_residual(sums, {shares[i], residuals[i], weights[i], acrosses[i]}, facing);
    return sums;
}

}  // namespace hexrelief::surface
