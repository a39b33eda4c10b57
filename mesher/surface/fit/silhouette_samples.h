// Finds the crack edges around a silhouette edge, and sums up its residuals to them.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/surface/fit/fit_silhouettes_step.h"
#include "pipeline/base/block_allocator.h"

namespace hexrelief::surface {

// Samples as a structure of arrays, so that loops over them vectorise: x, y, near_x and near_y of all
// samples, one array after the other, padded to a multiple of kSamplesAtOnce with samples of weight 0.
inline constexpr int kSamplesAtOnce = 8;
struct SilhouetteSamples {
    const float* values = nullptr;
    int count = 0;  // number of items in each array
};

// One thread's samples, whose addresses stay valid, and its buffers.
class SilhouetteSampler {
  public:
    explicit SilhouetteSampler(const step::PixelView& view) : view_(view) {}

    // Finds all samples within reach_px of the edge p -> q, and a few more; they live as long as the sampler.
    SilhouetteSamples find(const Vec2f& p, const Vec2f& q, float reach_px);
    // Returns the sums of the edge's residuals to the samples.
    step::SilhouetteResiduals residuals(const step::SilhouetteEdgeFrame& edge,
                                        const SilhouetteSamples& samples);

  private:
    step::PixelView view_;
    BlockAllocator<float> found_;
    std::vector<step::SilhouetteSample> buffer_;  // samples being found
    std::vector<float> residuals_;                // of one edge, as a structure of arrays
    std::vector<std::uint32_t> weighing_;         // indices of its samples with a weight
};

}  // namespace hexrelief::surface
