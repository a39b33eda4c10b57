// The crack edges around a silhouette edge, and the residuals that it has to them.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/common/block_allocator.h"
#include "mesher/surface/fit/fit_silhouettes_step.h"

namespace hexrelief::surface {

// Samples as arrays, so that loops over them become vectors: x, y, near_x and near_y of all, one array after
// the other, filled up to a multiple of kSamplesAtOnce with samples that weigh nothing.
inline constexpr int kSamplesAtOnce = 8;
struct SilhouetteSamples {
    const float* values = nullptr;
    int count = 0;  // items of each array
};

// One thread's: the samples that it found, which stay where they are, and buffers.
class SilhouetteSampler {
  public:
    explicit SilhouetteSampler(const step::PixelView& view) : view_(view) {}

    // All samples within reach_px of the edge p -> q, and some more; they live as long as the sampler.
    SilhouetteSamples find(const Vec2f& p, const Vec2f& q, float reach_px);
    // The sums of the edge's residuals to the samples.
    step::SilhouetteResiduals residuals(const step::SilhouetteEdgeFrame& edge,
                                        const SilhouetteSamples& samples);

  private:
    step::PixelView view_;
    BlockAllocator<float> found_;
    std::vector<step::SilhouetteSample> buffer_;  // those being found
    std::vector<float> residuals_;                // of one edge, as arrays
    std::vector<std::uint32_t> weighing_;         // its samples with a weight
};

}  // namespace hexrelief::surface
