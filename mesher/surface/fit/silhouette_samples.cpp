#include "mesher/surface/fit/silhouette_samples.h"

#include <algorithm>
#include <cmath>

namespace hexrelief {

std::span<const step::SilhouetteSample> SilhouetteSampler::find(const Vec2f& p, const Vec2f& q,
                                                                float reach_px) {
    const step::PixelBox box = step::pixels_around(view_, p, q, reach_px);
    const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
    const float around = reach_px + step::kRounding_px;
    const float most = around * around * size2;
    // along the edge, as shares of its squared size
    const float before = -around * std::sqrt(size2), beyond = size2 - before;
    buffer_.clear();
    for (int y = box.y0; y <= box.y1; ++y)
        for (int x = box.x0; x <= box.x1; ++x) {
            const int flags = view_.flags[view_.index(x, y)];
            if (!(flags & (step::kDiscontinuityRight | step::kDiscontinuityDown))) continue;
            for (int down = 0; down < 2; ++down) {
                if (!(flags & (down ? step::kDiscontinuityDown : step::kDiscontinuityRight))) continue;
                const step::SilhouetteSample sample = step::silhouette_sample(view_, {x, y, down});
                const float mx = sample.x - p.x, my = sample.y - p.y;
                const float off = my * dx - mx * dy, along = mx * dx + my * dy;
                if (off * off <= most && along >= before && along <= beyond) buffer_.push_back(sample);
            }
        }
    step::SilhouetteSample* const samples = found_.allocate(buffer_.size());
    std::copy(buffer_.begin(), buffer_.end(), samples);
    return {samples, buffer_.size()};
}

step::SilhouetteResiduals SilhouetteSampler::residuals(const step::SilhouetteEdgeFrame& edge,
                                                       std::span<const step::SilhouetteSample> samples) {
    if (weighing_.size() < samples.size()) weighing_.resize(2 * samples.size());
    std::size_t count = 0;
    double facing = 0;
    for (const step::SilhouetteSample& sample : samples) {  // no branch, which could not be foreseen
        const step::SilhouetteResidual residual = step::silhouette_residual(edge, sample);
        facing += residual.weight * residual.across;
        weighing_[count] = residual;
        count += residual.weight != 0;
    }
    step::SilhouetteResiduals sums{};
    for (std::size_t i = 0; i < count; ++i) step::add_residual(sums, weighing_[i], facing);
    return sums;
}

}  // namespace hexrelief
