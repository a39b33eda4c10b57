// Goes through the crack edges around a mesh edge of a silhouette, by a warp.
#pragma once

#include "cuda/common/grid.cuh"
#include "mesher/surface/fit/fit_silhouettes_step.h"

namespace hexrelief::cuda {

// The crack edges around a mesh edge, as a warp finds them.
class EdgeWarp {
  public:
    // Takes those up to around_px from the edge a-b, and more.
    __device__ EdgeWarp(const step::PixelView& view, const Vec2f& a, const Vec2f& b, float around_px)
        : view_(view),
          box_(step::pixels_around(view, a, b, around_px)),
          width_(box_.x1 - box_.x0 + 1),
          per_width_(1 / static_cast<float>(width_)) {}

    // Calls visit(is_one, sample) for up to 32 samples at a time, one per lane, in the order of their pixels.
    template <typename Visit>
    __device__ void each_32(const Visit& visit) const {
        std::uint8_t* const list = own_list();
        const int lane = static_cast<int>(threadIdx.x % 32);
        const int pixels = width_ * (box_.y1 - box_.y0 + 1);
        HEXRELIEF_ROLLED
        for (int start = 0; start < pixels; start += kPixels) {
            const int count = list_discontinuities(start, pixels, lane, list);
            HEXRELIEF_ROLLED
            for (int c = 0; c < count; c += 32) {
                const bool is_one = c + lane < count;
                step::SilhouetteSample sample{};
                if (is_one) {
                    const int item = list[c + lane];
                    const BoxPixel at = pixel_at(start + item / 2);
                    sample = step::silhouette_sample(view_, {at.x, at.y, item % 2});
                }
                visit(is_one, sample);
            }
            __syncwarp();
        }
    }
    // Returns the sums of the edge from a to b over all these samples, without a limit on their number.
    __device__ step::SilhouetteResiduals see(const Vec2f& a, const Vec2f& b) const {
        const step::SilhouetteEdgeFrame frame = step::silhouette_edge_frame(a, b);
        step::SilhouetteResiduals sums{};
        if (!(frame.size2 > 0)) return sums;
        double facing = 0;
        HEXRELIEF_ROLLED
        for (int pass = 0; pass < 2; ++pass)
            each_32([&](bool is_one, const step::SilhouetteSample& sample) {
                const step::SilhouetteResidual pull =
                    is_one ? step::silhouette_residual(frame, sample) : step::SilhouetteResidual{};
                HEXRELIEF_ROLLED
                for (unsigned lanes = __ballot_sync(~0u, pull.weight != 0); lanes; lanes &= lanes - 1) {
                    const int from = __ffs(lanes) - 1;
                    const step::SilhouetteResidual one{
                        __shfl_sync(~0u, pull.share, from), __shfl_sync(~0u, pull.residual, from),
                        __shfl_sync(~0u, pull.weight, from), __shfl_sync(~0u, pull.across, from)};
                    if (pass == 0)
                        facing += one.weight * one.across;
                    else
                        step::add_residual(sums, one, facing);
                }
            });
        return sums;
    }

  private:
    static constexpr int kPixels = 128;  // read together

    // A pixel of the box, which is counted row by row.
    struct BoxPixel {
        int x, y;
    };
    __device__ BoxPixel pixel_at(int i) const {
        // exact for small i: the quotient is at least 0.5 / width away from an integer
        const int y = i < 65536 ? static_cast<int>((static_cast<float>(i) + 0.5f) * per_width_) : i / width_;
        return {box_.x0 + i - y * width_, box_.y0 + y};
    }
    __device__ static std::uint8_t* own_list() {
        __shared__ std::uint8_t lists[kGridWarps][2 * kPixels];
        return lists[threadIdx.x / 32];
    }
    // Lists the discontinuities of kPixels pixels as 2 * (pixel - start), + 1 for one to the lower neighbour.
    __device__ int list_discontinuities(int start, int pixels, int lane, std::uint8_t* list) const {
        int flags[kPixels / 32];
#pragma unroll
        for (int k = 0; k < kPixels / 32; ++k) {
            const int i = start + 32 * k + lane;
            const BoxPixel at = pixel_at(i);
            flags[k] = i < pixels ? view_.flags[view_.index(at.x, at.y)] : 0;
        }
        const unsigned before = (1u << lane) - 1;
        int count = 0;
#pragma unroll
        for (int k = 0; k < kPixels / 32; ++k) {
            const bool right = flags[k] & step::kDiscontinuityRight,
                       down = flags[k] & step::kDiscontinuityDown;
            const unsigned rights = __ballot_sync(~0u, right), downs = __ballot_sync(~0u, down);
            const int at = count + __popc(rights & before) + __popc(downs & before);
            const int sample = 2 * (32 * k + lane);
            if (right) list[at] = static_cast<std::uint8_t>(sample);
            if (down) list[at + right] = static_cast<std::uint8_t>(sample + 1);
            count += __popc(rights) + __popc(downs);
        }
        __syncwarp();
        return count;
    }

    const step::PixelView view_;
    step::PixelBox box_;
    int width_;
    float per_width_;
};

}  // namespace hexrelief::cuda
