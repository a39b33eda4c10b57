// The colours of PlaneRecord, which smoothing compares in few instructions.
#pragma once

#include <cstdint>

#include "pipeline/matching/refine/smooth_step.h"

namespace hexrelief::cuda {

// Channels are in fields of 10 bits, and the whole is subtracted from the largest 31-bit number: so a colour
// with all bits set stands for 2^31, which resembles no other.
struct PlaneColor {
    static constexpr std::uint32_t kFields = 1u | 1u << 10 | 1u << 20, kLimit = 1u << 9,
                                   kUnknown = 0xffffffffu;
    std::uint32_t less, more;

    __device__ static std::uint32_t packed(std::uint32_t color) {
        return 0x7fffffffu - ((color & 0xffu) | (color & 0xff00u) << 2 | (color & 0xff0000u) << 4);
    }
    // own: colour of the pixel with which others are compared.
    __device__ explicit PlaneColor(std::uint32_t own)
        : less((kLimit - 1 - step::kSmoothColor) * kFields - own),
          more((kLimit - 1 - step::kSmoothColor) * kFields + own) {}
    // True if a channel differs by more than kSmoothColor: then it reaches kLimit in one of the two sums.
    __device__ bool unlike(std::uint32_t other) const {
        return ((less + other) | (more - other)) & (kLimit * kFields | 1u << 31);
    }
};

}  // namespace hexrelief::cuda
