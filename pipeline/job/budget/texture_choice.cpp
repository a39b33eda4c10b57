#include "pipeline/job/budget/texture_choice.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::job {
namespace {

// Below this quality a JPEG's blocks are visible, and fewer pixels look better.
constexpr int kLeastQuality = 50, kQualityStep = 10, kShrunkQuality = 70;
constexpr int kLeastSide_px = 32;

}  // namespace

std::vector<TextureChoice> texture_choices(const TextureLimits& limits) {
    const auto [max_px, quality] = limits.configured;
    std::vector<TextureChoice> choices{limits.configured};
    const bool falls = limits.may_lose_quality && quality > kLeastQuality;
    if (falls) {
        for (int lower = (quality - 1) / kQualityStep * kQualityStep; lower >= kLeastQuality;
             lower -= kQualityStep)
            choices.push_back({max_px, lower});
    }
    if (!limits.may_shrink) return choices;
    for (int step = 1;; ++step) {
        const int side = static_cast<int>(std::lround(limits.longest_px * std::pow(0.5, 0.5 * step)));
        if (side < kLeastSide_px) return choices;
        choices.push_back({side, falls ? std::min(quality, kShrunkQuality) : quality});
        if (falls) choices.push_back({side, kLeastQuality});
    }
}

TextureChoice choose_texture(const TextureLimits& limits, double max_bytes, double share,
                             const std::function<double(const TextureChoice&)>& bytes) {
    const std::vector<TextureChoice> choices = texture_choices(limits);
    const auto first = std::partition_point(choices.begin(), choices.end(), [&](const TextureChoice& choice) {
        return bytes(choice) > share * max_bytes;
    });
    return first == choices.end() ? choices.back() : *first;
}

}  // namespace hexrelief::job
