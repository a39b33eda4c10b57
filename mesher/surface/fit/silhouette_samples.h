// Pixel sides with a discontinuity around an edge, and what they ask of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesher/common/block_allocator.h"
#include "mesher/surface/fit/fit_silhouettes_step.h"

namespace hexrelief {

inline constexpr int kSampleLanes = 16;  // sides that are looked at together

// Sides of pixels, as step::SilhouetteSample, a coordinate after the other, filled up to whole lanes with
// sides that weigh nothing.
struct SilhouetteSamples {
    const float* values = nullptr;  // x, y, near_x, near_y of all
    int count = 0;                  // a multiple of kSampleLanes
};

// One thread's: room for sides, which stay where they are, and for what is done with them.
class SilhouetteSampler {
  public:
    explicit SilhouetteSampler(const step::PixelView& view) : view_(view) {}

    // All sides within reach_px of the edge p -> q, and some more.
    SilhouetteSamples find(const Vec2f& p, const Vec2f& q, float reach_px);
    // What they ask of the edge.
    step::SilhouettePulls pulls(const step::SilhouetteEdgeFrame& edge, const SilhouetteSamples& sides);

  private:
    step::PixelView view_;
    Blocks<float> found_;
    std::vector<float> x_, y_, near_x_, near_y_;  // of the sides being found
    // of the pulls being summed
    std::vector<float> shares_, residuals_, weights_, acrosses_;
    std::vector<std::uint32_t> weighing_;  // those that do
};

}  // namespace hexrelief
