#include "pipeline/stages/other_views/backing_texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pipeline/stages/other_views/texture_level.h"
#include "pipeline/stages/other_views/texture_synthesis.h"

namespace hexrelief::stages {
namespace {

constexpr float kBehindContinued_px = 0.3F;  // of the left view

// Calls take(pixel, d) for the pixels of a view in front of the backing, which has the disparity d there, on
// the pool's threads.
template <class Take>
void for_backing(const OtherView& backing, const Disparities& front, const ViewPlace& place, ThreadPool& pool,
                 const Take& take) {
    const int by = static_cast<int>(backing.place.scale);
    pool.parallel_for_each(static_cast<std::size_t>(backing.place.height) * by, [&](std::size_t y) {
        for (int x = 0; x < backing.place.width * by; ++x) {
            const double d = backing.missing.at(x / by, static_cast<int>(y) / by) * backing.place.scale;
            const std::size_t i = y * place.width + x;
            if (front[i] - d > kOneSurface_px) take(i, d);
        }
    });
}

// Returns a picture of half the size, whose pixels are means of 2x2.
Image halved(const Image& picture) {
    Image half{picture.width / 2, picture.height / 2, picture.channels, {}};
    half.pixels.reserve(picture.pixels.size() / 4);
    for (int y = 0; y < half.height; ++y)
        for (int x = 0; x < half.width; ++x)
            for (int c = 0; c < half.channels; ++c)
                half.pixels.push_back(static_cast<std::uint8_t>(
                    (picture.at(2 * x, 2 * y)[c] + picture.at(2 * x + 1, 2 * y)[c] +
                     picture.at(2 * x, 2 * y + 1)[c] + picture.at(2 * x + 1, 2 * y + 1)[c] + 2) /
                    4));
    return half;
}

}  // namespace

void keep_behind_continued(OtherView& backing, const DisparityMap& missing) {
    const auto scale = static_cast<float>(backing.place.scale);
    const int by = static_cast<int>(backing.place.scale);
    for (int y = 0; y < backing.place.height * by; ++y)
        for (int x = 0; x < backing.place.width * by; ++x) {
            const float continued = missing.at(x, y);
            if (!DisparityMap::known(continued)) continue;
            for (DisparityMap* map : {&backing.map, &backing.missing})
                if (float& d = map->at(x / by, y / by); DisparityMap::known(d))
                    d = std::min(d, (continued - kBehindContinued_px) / scale);
        }
}

Continued backing_behind(const Continued& continued, const OtherView& backing, const Disparities& front,
                         const ViewPlace& place, ThreadPool& pool) {
    Continued behind(front.size());
    std::fill(behind.disparities.begin(), behind.disparities.end(), kNotCovered);
    for_backing(backing, front, place, pool, [&](std::size_t i, double d) {
        if (std::abs(continued.disparities[i] - d) > TextureLevel::tolerance_of(front[i] - d))
            behind.offer(i, d, 1, Continued::kNoColour);
    });
    for (std::uint32_t i = 0; i < front.size(); ++i)
        if (behind.disparities[i] != kNotCovered) behind.pixels.push_back(i);
    behind.is_mixed = continued.is_mixed;
    return behind;
}

void paint_backing(OtherView& backing, const Image& picture, const ViewPlace& place, Continued behind,
                   const Disparities& front, ThreadPool& pool) {
    Disparities shown = front;
    for_backing(backing, front, place, pool, [&](std::size_t i, double d) {
        if (behind.disparities[i] != kNotCovered) return;
        shown[i] = d;
        if (!behind.is_mixed.empty()) behind.is_mixed[i] = 0;
    });
    const bool is_small = std::min(picture.width, picture.height) < 2;
    Image& painted = backing.picture =
        with_texture(is_small ? picture : halved(picture), place, behind, shown, pool);
    const int by = static_cast<int>(backing.place.scale);
    for (const std::uint32_t pixel : behind.pixels) {
        const int x = static_cast<int>(pixel % place.width), y = static_cast<int>(pixel / place.width);
        if (!painted.empty())
            std::copy_n(backing.color.at(x / by, y / by), painted.channels,
                        painted.at(x * painted.width / place.width, y * painted.height / place.height));
    }
}

}  // namespace hexrelief::stages
