// Triggering step: the order-free parallel form of the learning rule (paper, Eq. 3 and 4).
//
// The units of an iteration are found on the positions at the start of the one before (of its own for the
// first), so that an iteration's competition runs beside the learning of the one before: one wait for all
// threads an iteration instead of two, at the same %cost (mean over the paper's small maps 20.4 either way).
// Each neuron gathers, from every unit k within the neighbourhood radius, its point p_k and a_k = alpha *
// h(d_k), and moves once:
//     w <- w + (1 - prod(1 - a_k)) * (sum(a_k p_k) / sum(a_k) - w)
// One unit gives Eq. 3. The sums are integers modulo 2^32, so neither their order nor the number of threads
// matters.
#pragma once

#include <cstdint>
#include <cstring>

#include "mesher/steps/host_device.h"

namespace hexrelief::step {

inline constexpr int kGainBits = 10;                  // h in [0, 1] as 0..1024
inline constexpr int kFallBits = 16;                  // -log2(1 - a) in 1/65536
inline constexpr std::uint32_t kFullFall = 1u << 20;  // 16 octaves: the neuron goes all the way

// Per neuron: sum of h, of h * p (p in half px) and of -log2(1 - alpha h).
struct Pull {
    std::uint32_t gain = 0, x = 0, y = 0, fall = 0;
};

// 2^-n exactly, n below 126: the bits of the float, where a division would cost as much as the rest of the
// share.
HEXRELIEF_HD float power_of_half(std::uint32_t n) {
    const std::uint32_t bits = (127u - n) << 23;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// 1 - 2^(-fall / 65536), the share of the way to the weighted mean point.
HEXRELIEF_HD float learning_share(std::uint32_t fall) {
    if (fall >= kFullFall) return 1.0f;
    const float t = static_cast<float>(fall & 0xFFFFu) * (0.69314718f / 65536.0f);
    float power = 1.0f - t * (1.0f / 7.0f);  // Horner form of exp(-t), t in [0, ln 2): error below 2e-6
    power = 1.0f - t * (1.0f / 6.0f) * power;
    power = 1.0f - t * (1.0f / 5.0f) * power;
    power = 1.0f - t * (1.0f / 4.0f) * power;
    power = 1.0f - t * (1.0f / 3.0f) * power;
    power = 1.0f - t * (1.0f / 2.0f) * power;
    power = 1.0f - t * power;
    return 1.0f - power * power_of_half(fall >> kFallBits);
}

// One coordinate's weighted mean point in px. Pulls are taken relative to the neuron's own half pixel, which
// turns the sum modulo 2^32 into the true one (exact while |sum h (p - base)| < 2^31: 2,000 units at 1,000
// px).
HEXRELIEF_HD float mean_point(float position, std::uint32_t pull, std::uint32_t gain) {
    const std::int32_t base = static_cast<std::int32_t>(position * 2.0f + 0.5f);
    const std::int32_t relative = static_cast<std::int32_t>(pull - gain * static_cast<std::uint32_t>(base));
    return (static_cast<float>(base) + static_cast<float>(relative) / static_cast<float>(gain)) * 0.5f;
}

// Moves one neuron; positions stay within [0, width] x [0, height] px. Precondition: pull.gain > 0.
HEXRELIEF_HD void learn(const Pull& pull, float width, float height, float& x, float& y) {
    const float share = learning_share(pull.fall);
    x = clamp_to(x + share * (mean_point(x, pull.x, pull.gain) - x), 0.0f, width);
    y = clamp_to(y + share * (mean_point(y, pull.y, pull.gain) - y), 0.0f, height);
}

}  // namespace hexrelief::step
