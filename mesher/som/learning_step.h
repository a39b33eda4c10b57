// Triggering step: the order-free parallel form of the learning rule (paper, Eq. 3 and 4).
//
// The units of a batch of up to prr iterations are all found on the positions at its start. A neuron needs no
// other neuron's position to learn, so threads wait for each other twice a batch instead of twice an
// iteration. Each neuron gathers from every unit k within the neighbourhood radius its point p_k and a_k =
// alpha * h(d_k), and moves once:
//     w <- w + (1 - prod(1 - a_k)) * (sum(a_k p_k) / sum(a_k) - w)
// With a single unit this is Eq. 3. The sums are integers modulo 2^32, so neither their order nor the
// number of threads matters.
#pragma once

#include <cstdint>
#include <cstring>

#include "pipeline/base/host_device.h"

namespace hexrelief::step {

inline constexpr int kGainBits = 10;   // h in [0, 1] as 0..1024
inline constexpr int kDecayBits = 16;  // -log2(1 - a) in 1/65536
// 16 octaves: the neuron moves all the way to its target
inline constexpr std::uint32_t kFullDecay = 1u << 20;

// Returns the end of the batch of iterations that begins at t. A batch ends at the next refresh of the cells.
HEXRELIEF_HD int batch_end(int t, int total, int crr, int prr) {
    return min_of(min_of(t + prr, (t / crr + 1) * crr), total);
}

// The sums that a neuron gathers from the units around it: h, h * p (p in half px) and -log2(1 - alpha h).
struct LearningSums {
    std::uint32_t gain = 0, x = 0, y = 0, decay = 0;
};

// Returns 2^-n exactly, for n < 126, by composing the float's bits: a division would cost as much as
// the rest of learning_share().
HEXRELIEF_HD float power_of_half(std::uint32_t n) {
    const std::uint32_t bits = (127u - n) << 23;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// Returns 1 - 2^(-decay / 65536), the share of the way to the weighted mean point that the neuron moves.
HEXRELIEF_HD float learning_share(std::uint32_t decay) {
    if (decay >= kFullDecay) return 1.0f;
    const float t = static_cast<float>(decay & 0xFFFFu) * (0.69314718f / 65536.0f);
    float power = 1.0f - t * (1.0f / 7.0f);  // Horner form of exp(-t), t in [0, ln 2): error below 2e-6
    power = 1.0f - t * (1.0f / 6.0f) * power;
    power = 1.0f - t * (1.0f / 5.0f) * power;
    power = 1.0f - t * (1.0f / 4.0f) * power;
    power = 1.0f - t * (1.0f / 3.0f) * power;
    power = 1.0f - t * (1.0f / 2.0f) * power;
    power = 1.0f - t * power;
    return 1.0f - power * power_of_half(decay >> kDecayBits);
}

// Returns one coordinate of the weighted mean point, px, from the sums of h * p and of h. The sum modulo 2^32
// gives the true one if it is taken relative to `near`, a position near the neuron: exact while |sum h (p -
// base)| < 2^31, that is up to 2,000 units at 1,000 px.
HEXRELIEF_HD float mean_point(float near, std::uint32_t sum, std::uint32_t gain) {
    const std::int32_t base = static_cast<std::int32_t>(near * 2.0f + 0.5f);
    const std::int32_t relative = static_cast<std::int32_t>(sum - gain * static_cast<std::uint32_t>(base));
    return (static_cast<float>(base) + static_cast<float>(relative) / static_cast<float>(gain)) * 0.5f;
}

// The point towards which a neuron moves, px, and the share of the way that it moves.
struct Target {
    float x = 0, y = 0, share = 0;
};

// Returns a neuron's target. (near_x, near_y) is its position at the start of the batch, so that the targets
// of all iterations of the batch can be computed together.
HEXRELIEF_HD Target target_of(const LearningSums& sums, float near_x, float near_y) {
    if (!sums.gain) return {};
    return {mean_point(near_x, sums.x, sums.gain), mean_point(near_y, sums.y, sums.gain),
            learning_share(sums.decay)};
}

// Moves one neuron towards its target; positions stay within [0, width] x [0, height] px.
HEXRELIEF_HD void learn(const Target& target, float width, float height, float& x, float& y) {
    x = clamp_to(x + target.share * (target.x - x), 0.0f, width);
    y = clamp_to(y + target.share * (target.y - y), 0.0f, height);
}

}  // namespace hexrelief::step
