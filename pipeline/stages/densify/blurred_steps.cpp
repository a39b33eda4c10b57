#include "pipeline/stages/densify/blurred_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "pipeline/stages/densify/densify.h"

namespace hexrelief::stages {
namespace {

constexpr std::array kReaches_px{3, 5, 8};  // from a pixel to both ends of the step
constexpr float kLeastStep_px = 3;
constexpr float kSteeper = 2.5F;       // than both ends
constexpr float kMostSlope = 0.35F;    // of the step, in a px: a sharp one has 0.5 on both sides
constexpr float kLeastSlope = 0.04F;   // of the step, over the reach: it rises all the way
constexpr float kEnd = 0.08F;          // of the step: what is nearer to an end lies on that surface
constexpr double kMoreThanSharp = 40;  // times; a true map has at most 0.7, a blurred one more than 100
constexpr float kOwnSide = 0.42F;  // of the step, from an end: what the blur has not brought to its middle
constexpr std::ptrdiff_t kOneSided = 6;  // bleeding has one side more by 1 of 4 pixels, a blur by 1 of 8
constexpr double kLeastBlurred = 0.001, kMostBlurred = 0.25;  // of the map

// A row or a column of the map.
struct Line {
    const float* first;
    std::ptrdiff_t stride;
    int length;
    float operator[](int i) const { return first[i * stride]; }
};

bool is_on_blurred_step(const Line& line, int i, int reach) {
    const float low = line[i - reach], high = line[i + reach], step = high - low, size = std::abs(step);
    if (!(size >= kLeastStep_px) || !DisparityMap::known(step)) return false;
    const float sign = step > 0 ? 1.0F : -1.0F;
    const float before = sign * (line[i] - line[i - 1]), after = sign * (line[i + 1] - line[i]);
    const float slope = (before + after) / 2, least = kLeastSlope * size / static_cast<float>(reach);
    const float first_end = std::abs(line[i - reach + 1] - line[i - reach - 1]) / 2;
    const float last_end = std::abs(line[i + reach + 1] - line[i + reach - 1]) / 2;
    const float part = (line[i] - low) / step;
    return before > least && after > least && slope <= kMostSlope * size &&
           slope >= kSteeper * std::max(first_end, last_end) && part > kEnd && part < 1 - kEnd;
}

// True if most of what the map rises around two neighbours, it rises between them.
bool is_sharp_step(const Line& line, int i) {
    const float step = std::abs(line[i + 1] - line[i]);
    const float around = std::abs(line[std::min(i + 4, line.length - 1)] - line[std::max(i - 3, 0)]);
    return DisparityMap::known(step) && step >= kLeastStep_px && !(around > 2 * step);
}

bool is_on_other_side(float d, const std::array<float, 2>& ends) {
    return std::abs(d - ends[0]) > std::abs(d - ends[1]);
}

struct Steps {
    std::vector<std::uint8_t> blurred;  // 1 for each pixel on a blurred step
    std::vector<std::array<float, 2>>
        ends;               // of the largest one there, first that nearer to the pixel's value
    std::size_t sharp = 0;  // pairs of neighbours with a sharp one between them
};

Steps find_steps(const DisparityMap& map) {
    Steps steps{std::vector<std::uint8_t>(map.values.size(), 0),
                std::vector<std::array<float, 2>>(map.values.size(), {0, 0}), 0};
    const auto search = [&](std::size_t start, std::ptrdiff_t stride, int length) {
        const Line line{map.values.data() + start, stride, length};
        for (int i = 0; i + 1 < length; ++i) steps.sharp += is_sharp_step(line, i);
        for (const int reach : kReaches_px)
            for (int i = reach + 1; i < length - reach - 1; ++i)
                if (is_on_blurred_step(line, i, reach)) {
                    const auto pixel = start + static_cast<std::size_t>(i * stride);
                    std::array ends{line[i - reach], line[i + reach]};
                    if (is_on_other_side(line[i], ends)) std::swap(ends[0], ends[1]);
                    auto& largest = steps.ends[pixel];
                    if (std::abs(ends[1] - ends[0]) > std::abs(largest[1] - largest[0])) largest = ends;
                    steps.blurred[pixel] = 1;
                }
    };
    for (int y = 0; y < map.height; ++y) search(static_cast<std::size_t>(y) * map.width, 1, map.width);
    for (int x = 0; x < map.width; ++x) search(static_cast<std::size_t>(x), map.width, map.height);
    return steps;
}

// Returns the flags of 3x3 pixels joined.
std::vector<std::uint8_t> with_neighbours(const std::vector<std::uint8_t>& flags, int width, int height) {
    std::vector<std::uint8_t> wider(flags.size(), 0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (!flags[static_cast<std::size_t>(y) * width + x]) continue;
            for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u)
                    wider[static_cast<std::size_t>(v) * width + u] = 1;
        }
    return wider;
}

// Puts pixels back to the side of the step that they had in the blurred map, except those in its middle. The
// colours decide alone if they move pixels to one side of the step, as where a thing bleeds over its edge; if
// they move as many to the other side, that is their own error.
void keep_sides(DisparityMap& filled, const DisparityMap& blurred, const Steps& steps) {
    std::ptrdiff_t same = 0, to_one_side = 0;
    for (std::size_t i = 0; i < filled.values.size(); ++i) {
        if (!steps.blurred[i]) continue;
        if (const auto& ends = steps.ends[i]; !is_on_other_side(filled.values[i], ends))
            ++same;
        else
            to_one_side += ends[0] < ends[1] ? 1 : -1;
    }
    if (kOneSided * std::abs(to_one_side) >= same) return;
    for (std::size_t i = 0; i < filled.values.size(); ++i) {
        const auto& ends = steps.ends[i];
        if (steps.blurred[i] && is_on_other_side(filled.values[i], ends) &&
            std::abs(blurred.values[i] - ends[0]) < kOwnSide * std::abs(ends[1] - ends[0]))
            filled.values[i] = ends[0];
    }
}

}  // namespace

SharpenedMap sharpen_steps(DisparityMap map, const Image& left, int threads) {
    const Steps steps = find_steps(map);
    const auto all = static_cast<double>(map.values.size());
    const auto found = static_cast<double>(std::ranges::count(steps.blurred, std::uint8_t{1}));
    if (found <= kMoreThanSharp * static_cast<double>(steps.sharp) || found < kLeastBlurred * all)
        return {std::move(map), 0};
    const std::vector<std::uint8_t> blurred = with_neighbours(steps.blurred, map.width, map.height);
    const double share = static_cast<double>(std::ranges::count(blurred, std::uint8_t{1})) / all;
    if (share > kMostBlurred) return {std::move(map), 0};
    DisparityMap open{map.width, map.height, map.values, {}};
    for (std::size_t i = 0; i < blurred.size(); ++i)
        if (blurred[i]) open.values[i] = kUnknownDisparity;
    DisparityMap filled = fill_holes(open, left, threads);
    keep_sides(filled, map, steps);
    for (std::size_t i = 0; i < blurred.size(); ++i)
        if (blurred[i] && DisparityMap::known(map.values[i])) map.values[i] = filled.values[i];
    return {std::move(map), share};
}

}  // namespace hexrelief::stages
