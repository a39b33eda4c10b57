#include "tests/cuda/paper/balls_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace hexrelief::paper {
namespace {

constexpr int kBalls = 24;
constexpr float kUnknownShare = 0.02f;

// Returns a number uniform in [0, 1), by an integer hash (splitmix64), so that the scene does not
// depend on a library.
float uniform(std::uint64_t counter) {
    std::uint64_t z = (counter + 1) * 0x9E3779B97F4A7C15ull;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return static_cast<float>((z ^ (z >> 31)) >> 40) * 0x1p-24f;
}

void paint_ball(DisparityMap& map, int ball) {
    const std::uint64_t first = static_cast<std::uint64_t>(ball) * 4;
    const float side = static_cast<float>(std::min(map.width, map.height));
    const float x = uniform(first) * static_cast<float>(map.width);
    const float y = uniform(first + 1) * static_cast<float>(map.height);
    const float radius = (0.02f + 0.1f * uniform(first + 2)) * side;
    const float far = 20 + 36 * uniform(first + 3);
    const int top = std::max(0, static_cast<int>(y - radius)),
              bottom = std::min(map.height - 1, static_cast<int>(y + radius));
    const int left = std::max(0, static_cast<int>(x - radius)),
              right = std::min(map.width - 1, static_cast<int>(x + radius));
    for (int row = top; row <= bottom; ++row)
        for (int column = left; column <= right; ++column) {
            const float u = (static_cast<float>(column) + 0.5f - x) / radius;
            const float v = (static_cast<float>(row) + 0.5f - y) / radius;
            const float rest = 1 - u * u - v * v;
            if (rest <= 0) continue;
            float& d = map.at(column, row);
            d = std::max(d, far + 8 * std::sqrt(rest));
        }
}

}  // namespace

DisparityMap made_up_scene(int width, int height) {
    DisparityMap map{width, height, std::vector<float>(static_cast<std::size_t>(width) * height), {}};
    for (int row = 0; row < height; ++row) {
        const float v = (static_cast<float>(row) + 0.5f) / static_cast<float>(height);
        const float d = v < 0.4f ? 6.0f : 6.0f + (v - 0.4f) * 40;
        std::fill_n(map.values.begin() + static_cast<std::ptrdiff_t>(row) * width, width, d);
    }
    for (int ball = 0; ball < kBalls; ++ball) paint_ball(map, ball);
    const int blind = static_cast<int>(kUnknownShare * static_cast<float>(width));
    for (int row = 0; row < height; ++row)
        std::fill_n(map.values.begin() + static_cast<std::ptrdiff_t>(row) * width, blind, kUnknownDisparity);
    return map;
}

}  // namespace hexrelief::paper
