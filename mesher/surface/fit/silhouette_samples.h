// The crack edges around a silhouette edge, and the residuals that it has to them.
#pragma once

#include <span>
#include <vector>

#include "mesher/common/block_allocator.h"
#include "mesher/surface/fit/fit_silhouettes_step.h"

namespace hexrelief {

// One thread's: the samples that it found, which stay where they are, and buffers.
class SilhouetteSampler {
  public:
    explicit SilhouetteSampler(const step::PixelView& view) : view_(view) {}

    // All samples within reach_px of the edge p -> q, and some more; they live as long as the sampler.
    std::span<const step::SilhouetteSample> find(const Vec2f& p, const Vec2f& q, float reach_px);
    // The sums of the edge's residuals to the samples.
    step::SilhouetteResiduals residuals(const step::SilhouetteEdgeFrame& edge,
                                        std::span<const step::SilhouetteSample> samples);

  private:
    step::PixelView view_;
    BlockAllocator<step::SilhouetteSample> found_;
    std::vector<step::SilhouetteSample> buffer_;      // those being found
    std::vector<step::SilhouetteResidual> weighing_;  // of one edge, those with a weight
};

}  // namespace hexrelief
