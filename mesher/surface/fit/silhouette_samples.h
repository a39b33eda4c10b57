// Pixel sides with a discontinuity around an edge, and what they ask of it.
#pragma once

#include <span>
#include <vector>

#include "mesher/common/block_allocator.h"
#include "mesher/surface/fit/fit_silhouettes_step.h"

namespace hexrelief {

// One thread's: the samples that it found, which stay where they are, and room for the residuals of an edge.
class SilhouetteSampler {
  public:
    explicit SilhouetteSampler(const step::PixelView& view) : view_(view) {}

    // All samples within reach_px of the edge p -> q, and some more; they live as long as the sampler.
    std::span<const step::SilhouetteSample> find(const Vec2f& p, const Vec2f& q, float reach_px);
    // What the samples ask of the edge.
    step::SilhouetteResiduals residuals(const step::SilhouetteEdgeFrame& edge,
                                        std::span<const step::SilhouetteSample> samples);

  private:
    step::PixelView view_;
    BlockAllocator<step::SilhouetteSample> found_;
    std::vector<step::SilhouetteSample> buffer_;      // for those being found
    std::vector<step::SilhouetteResidual> weighing_;  // those of the edge that weigh anything
};

}  // namespace hexrelief
