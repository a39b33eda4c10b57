// Words that hold one 16-bit number, as a lane of a CPU's vector does, or two in their halves, as a device's
// register does. Steps are templates of the word, so that both backends call the same text. Callers make sure
// that sums and differences stay within their halves.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"

namespace hexrelief::step {

inline constexpr std::uint32_t kBoth = 0x00010001u;  // 1 in either half

// Returns the number in each half of a word.
template <typename Word>
HEXRELIEF_HD constexpr Word in_halves(std::uint32_t number) {
    return static_cast<Word>(sizeof(Word) == sizeof(std::uint32_t) ? number * kBoth : number);
}

// Returns the minimum of each half.
HEXRELIEF_HD std::uint8_t least_of(std::uint8_t a, std::uint8_t b) {
    return a < b ? a : b;
}
HEXRELIEF_HD std::uint16_t least_of(std::uint16_t a, std::uint16_t b) {
    return a < b ? a : b;
}
HEXRELIEF_HD std::uint32_t least_of(std::uint32_t a, std::uint32_t b) {
#ifdef __CUDA_ARCH__
    return __vminu2(a, b);
#else
    const std::uint32_t low_a = a & 0xffffu, low_b = b & 0xffffu;
    const std::uint32_t high_a = a & ~0xffffu, high_b = b & ~0xffffu;
    return (low_a < low_b ? low_a : low_b) | (high_a < high_b ? high_a : high_b);
#endif
}
template <typename Word>
HEXRELIEF_HD Word least_of(Word a, Word b, Word c) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
    if constexpr (sizeof(Word) == sizeof(std::uint32_t)) return __vimin3_u16x2(a, b, c);
#endif
    return least_of(least_of(a, b), c);
}

// Returns min(a - b, c) in each half; a >= b. minus_b: 2^16 - b.
HEXRELIEF_HD std::uint16_t least_of_difference(std::uint16_t a, std::uint16_t b, std::uint16_t /*minus_b*/,
                                               std::uint16_t c) {
    return least_of(static_cast<std::uint16_t>(a - b), c);
}
HEXRELIEF_HD std::uint32_t least_of_difference(std::uint32_t a, [[maybe_unused]] std::uint32_t b,
                                               [[maybe_unused]] std::uint32_t minus_b, std::uint32_t c) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
    return __viaddmin_u16x2(a, minus_b, c);
#else
    return least_of(a - b, c);
#endif
}

// Returns min(a + b, c) in each half; the sum wraps around at 2^16.
HEXRELIEF_HD std::uint16_t least_of_sum(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
    return least_of(static_cast<std::uint16_t>(a + b), c);
}
HEXRELIEF_HD std::uint32_t least_of_sum(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
#ifdef __CUDA_ARCH__
    return __viaddmin_u16x2(a, b, c);
#else
    return least_of((a & ~0xffffu) + (b & ~0xffffu) + ((a + b) & 0xffffu), c);
#endif
}

// Returns max(min(a + b, c), 0) in each half, for signed numbers.
HEXRELIEF_HD std::uint16_t least_of_sum_or_0(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
    const auto sum = static_cast<std::int16_t>(a + b), other = static_cast<std::int16_t>(c);
    const std::int16_t least = sum < other ? sum : other;
    return static_cast<std::uint16_t>(least > 0 ? least : std::int16_t{0});
}
HEXRELIEF_HD std::uint32_t least_of_sum_or_0(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
#ifdef __CUDA_ARCH__
    return __viaddmin_s16x2_relu(a, b, c);
#else
    const auto half = [&](int shift) -> std::uint32_t {
        return least_of_sum_or_0(static_cast<std::uint16_t>(a >> shift),
                                 static_cast<std::uint16_t>(b >> shift),
                                 static_cast<std::uint16_t>(c >> shift));
    };
    return half(0) | half(16) << 16;
#endif
}

// Returns factor * a * b, added over the halves. Each half of a and b fits into a byte, or that of a is 0.
HEXRELIEF_HD std::uint32_t sum_of_products(std::uint16_t factor, std::uint16_t a, std::uint16_t b) {
    return static_cast<std::uint32_t>(static_cast<std::uint16_t>(factor * a)) * b;
}
HEXRELIEF_HD std::uint32_t sum_of_products(std::uint32_t factor, std::uint32_t a, std::uint32_t b) {
#ifdef __CUDA_ARCH__
    return factor * __dp4a(a, b, 0u);
#else
    return factor * ((a & 0xffffu) * (b & 0xffffu) + (a >> 16) * (b >> 16));
#endif
}

}  // namespace hexrelief::step
