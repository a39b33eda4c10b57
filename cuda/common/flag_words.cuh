// The flags of 32 pixels of a row in words, with one bit per pixel.
#pragma once

#include <cstdint>

#include "cuda/common/surface_state.h"
#include "cuda/common/triangle_groups.cuh"
#include "mesher/surface/pixels/crack_edges_step.h"

namespace hexrelief::cuda {

// Returns a word with bits first .. end - 1 set, as far as they are within 0 .. 31.
__device__ inline unsigned bits_between(int first, int end) {
    first = max(first, 0);
    end = min(end, 32);
    return first < end ? static_cast<unsigned>((1ull << end) - (1ull << first)) : 0;
}

// Packs the flags of a map and reads them 32 at a time.
class FlagWords {
  public:
    // The flags of 32 successive pixels, the first one in bit 0.
    struct Bits {
        unsigned right, down, trusted;
    };

    FlagWords() = default;
    __device__ FlagWords(uint4* words, const step::PixelView& view)
        : words_(words), view_(view), per_row_(flag_words_per_row(view.width)) {}

    // Reads all flags of the map; a barrier must follow.
    __device__ void fill(const CooperativeGrid& grid) const {
        constexpr unsigned kAtOnce = 8;  // the number of loads in flight decides the speed
        const unsigned count = per_row_ * view_.height, lane = grid.lane(), warps = grid.warps();
        HEXRELIEF_ROLLED
        for (unsigned start = grid.warp() * kAtOnce; start < count; start += kAtOnce * warps) {
            unsigned flags[kAtOnce];
            HEXRELIEF_UNROLL
            for (unsigned k = 0; k < kAtOnce; ++k) {
                const unsigned row = (start + k) / per_row_;
                const int y = static_cast<int>(row),
                          x = static_cast<int>(32 * (start + k - row * per_row_) + lane);
                flags[k] = y < view_.height && x < view_.width ? view_.flags[view_.index(x, y)] : 0;
            }
            uint4 mine{};
            HEXRELIEF_UNROLL
            for (unsigned k = 0; k < kAtOnce; ++k) {
                const unsigned right = __ballot_sync(kAllLanes, flags[k] & step::kDiscontinuityRight),
                               down = __ballot_sync(kAllLanes, flags[k] & step::kDiscontinuityDown),
                               trusted = __ballot_sync(kAllLanes, flags[k] & step::kTrusted);
                if (lane == k) mine = {right, down, trusted, 0};
            }
            if (lane < kAtOnce && start + lane < count) words_[start + lane] = mine;
        }
    }
    // Returns the flags of pixels x .. x + 31 of row y, 0 for those beyond the row's end.
    __device__ Bits from(int x, int y) const {
        const uint4* const at = words_ + (static_cast<unsigned>(y) * per_row_ + x / 32);
        const uint4 a = at[0], b = at[1];
        const unsigned shift = x % 32;
        return {__funnelshift_r(a.x, b.x, shift), __funnelshift_r(a.y, b.y, shift),
                __funnelshift_r(a.z, b.z, shift)};
    }
    // Counts the discontinuities to the right neighbour among pixels first .. end - 1 of a row.
    __device__ unsigned discontinuities_right(int y, int first, int end) const {
        unsigned discontinuities = 0;
        HEXRELIEF_ROLLED
        for (int x = first; x < end; x += 32)
            discontinuities += __popc(from(x, y).right & bits_between(0, end - x));
        return discontinuities;
    }

    // A view for steps that read single pixels.
    struct View {
        struct Flags {
            const FlagWords& words;
            __device__ unsigned operator[](const step::Pixel& at) const {
                const uint4 word = words.words_[static_cast<unsigned>(at.y) * words.per_row_ + at.x / 32];
                const unsigned bit = at.x % 32;
                return (word.x >> bit & 1) * step::kDiscontinuityRight |
                       (word.y >> bit & 1) * step::kDiscontinuityDown;
            }
        };
        int width, height;
        Flags flags;
        __device__ static step::Pixel index(int x, int y) { return {x, y}; }
    };
    __device__ View view() const { return {view_.width, view_.height, {*this}}; }

  private:
    uint4* words_;
    step::PixelView view_;
    unsigned per_row_;
};

}  // namespace hexrelief::cuda
