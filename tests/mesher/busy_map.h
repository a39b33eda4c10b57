// Makes up maps full of silhouettes, holes, speckles and noise from a number.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"

namespace hexrelief::testing_mesher {

inline std::uint32_t hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t h = a * 0x9E3779B1u ^ b * 0x85EBCA77u ^ c * 0xC2B2AE3Du;
    h ^= h >> 15;
    h *= 0x2C1B3C6Du;
    h ^= h >> 12;
    h *= 0x297A2D39u;
    return h ^ h >> 15;
}
inline float uniform(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return static_cast<float>(hash(a, b, c) >> 8) / 16777216.0f;
}

// Returns a map of slopes, discs and bars at many disparities, with holes, speckles and noise.
inline DisparityMap busy_map(int width, int height, std::uint32_t seed) {
    DisparityMap map{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float d = 12 + 0.02f * static_cast<float>(y) + 0.01f * static_cast<float>(x);
            for (std::uint32_t k = 0; k < 60; ++k) {
                const float u = uniform(seed, k, 1) * width, v = uniform(seed, k, 2) * height,
                            r = 5 + 40 * uniform(seed, k, 3), near = 15 + 60 * uniform(seed, k, 4);
                const float dx = static_cast<float>(x) - u, dy = static_cast<float>(y) - v;
                const bool bar = k % 3 == 0;
                const bool inside = bar ? std::fabs(dx + 0.3f * dy) < r / 4 && std::fabs(dy) < 2 * r
                                        : dx * dx + dy * dy < r * r;
                if (inside) d = k % 7 == 0 ? 0 : std::max(d, near + 0.05f * dx);
            }
            const std::uint32_t i = static_cast<std::uint32_t>(y * width + x);
            d += d > 0 ? 0.3f * uniform(seed, i, 5) : 0;
            if (uniform(seed, i, 6) < 0.002f) d = 70 * uniform(seed, i, 7);
            map.values.push_back(d > 0 ? std::round(d * 65536) / 65536 : kUnknownDisparity);
        }
    return map;
}

inline Image busy_picture(const DisparityMap& map, std::uint32_t seed) {
    Image image{map.width, map.height, 3, {}};
    for (std::size_t i = 0; i < map.values.size(); ++i)
        for (std::uint32_t c = 0; c < 3; ++c)
            image.pixels.push_back(static_cast<std::uint8_t>(
                (std::isfinite(map.values[i]) ? 2.5f * map.values[i] : 0) + 30 * uniform(seed, i, 8 + c)));
    return image;
}

}  // namespace hexrelief::testing_mesher
