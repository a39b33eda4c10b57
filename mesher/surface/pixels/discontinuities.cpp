#include "mesher/surface/pixels/discontinuities.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "mesher/surface/pixels/eight_flags.h"
#include "mesher/surface/pixels/half_occlusion_step.h"
#include "mesher/surface/pixels/speckles.h"
#include "pipeline/base/simd.h"

namespace hexrelief::surface {
namespace {

// Runs body(first, last) on strips of rows; short strips, because one half of an image may hold
// most of the discontinuities.
template <typename Body>
void each_rows(const PixelSurfaces& s, ThreadPool& pool, const Body& body) {
    ThreadPool::ChunkCounters chunk_counters(pool.size());
    pool.run([&](int thread) {
        pool.run_chunks<16>(static_cast<std::size_t>(s.height), thread, chunk_counters,
                            [&](std::size_t first, std::size_t last) {
                                body(static_cast<int>(first), static_cast<int>(last));
                            });
    });
}

// Writes into `flags` the steps between the pixels d and their right and lower neighbours.
HEXRELIEF_VECTORS void find_steps(const float* d, const float* below, int count, float least,
                                  std::uint8_t* flags) {
#pragma GCC ivdep
    for (int x = 0; x < count; ++x)
        flags[x] = static_cast<std::uint8_t>((flags[x] & step::kTrusted) |
                                             step::steps_at(d[x], d[x + 1], below[x], least));
}

// Settles one row. `from` holds it with two zeros before and after it.
HEXRELIEF_VECTORS void settle_half_occlusions(const float* __restrict from, int width, float least,
                                              float* __restrict to) {
    for (int x = 0; x < width; ++x)
        to[x] =
            step::between_half_occlusions(from[x], from[x + 1], from[x + 2], from[x + 3], from[x + 4], least);
}

void settle_half_occlusions(PixelSurfaces& s, float least, ThreadPool& pool) {
    each_rows(s, pool, [&](int first, int last) {
        std::vector<float> row(static_cast<std::size_t>(s.width) + 4, 0.0f);
        for (int y = first; y < last; ++y) {
            float* const d = &s.disparity[static_cast<std::size_t>(y) * s.width];
            std::copy_n(d, s.width, row.data() + 2);
            settle_half_occlusions(row.data(), s.width, least, d);
        }
    });
}

// Calls visit(x, down, flag) for the discontinuities of a row.
template <typename Visit>
void for_each_discontinuity(const std::uint8_t* flags, int width, const Visit& visit) {
    for (int x = 0; x < width; ++x) {
        if (x + 8 <= width && !(eight_flags(flags + x) & kCracksOfEight)) {  // the usual case
            x += 7;
            continue;
        }
        const int own = flags[x];
        if (own & step::kDiscontinuityRight) visit(x, 0, step::kDiscontinuityRight);
        if (own & step::kDiscontinuityDown) visit(x, 1, step::kDiscontinuityDown);
    }
}

void find_discontinuities_in_row(PixelSurfaces& s, int y, float least) {
    const int width = s.width;
    const float* d = &s.disparity[static_cast<std::size_t>(y) * width];
    const float* below = y + 1 < s.height ? d + width : d;
    std::uint8_t* flags = &s.flags[static_cast<std::size_t>(y) * width];
    find_steps(d, below, width - 1, least, flags);
    const float last[2] = {d[width - 1], d[width - 1]};  // the last pixel has no right neighbour
    find_steps(last, below + width - 1, 1, least, flags + width - 1);
    for_each_discontinuity(flags, width, [&](int x, int down, std::uint8_t discontinuity) {
        if (!step::is_discontinuity_of_step(d + x, {x, y, down}, width, s.height, least))
            flags[x] &= static_cast<std::uint8_t>(~discontinuity);
    });
}

void find_discontinuities(PixelSurfaces& s, float least, ThreadPool& pool) {
    each_rows(s, pool, [&](int first, int last) {
        for (int y = first; y < last; ++y) find_discontinuities_in_row(s, y, least);
    });
}

// Recomputes the discontinuities of one pixel.
void find_discontinuities_of_pixel(PixelSurfaces& s, int x, int y, float least) {
    const std::size_t i = static_cast<std::size_t>(y) * s.width + x;
    const float* const d = &s.disparity[i];
    const int steps =
        step::steps_at(*d, x + 1 < s.width ? d[1] : *d, y + 1 < s.height ? d[s.width] : *d, least);
    int discontinuities = 0;
    for (int down = 0; down < 2; ++down) {
        const int discontinuity = down ? step::kDiscontinuityDown : step::kDiscontinuityRight;
        if ((steps & discontinuity) &&
            step::is_discontinuity_of_step(d, {x, y, down}, s.width, s.height, least))
            discontinuities |= discontinuity;
    }
    s.flags[i] = static_cast<std::uint8_t>((s.flags[i] & step::kTrusted) | discontinuities);
}

// Updates the discontinuities after the disparities of these pixels have changed.
void find_discontinuities_again(PixelSurfaces& s, const std::vector<std::uint32_t>& pixels, float least,
                                ThreadPool& pool) {
    // Number of pixels, taken row by row, that take as long as the neighbourhood of one changed pixel.
    constexpr std::size_t kLocalShare = 100;
    if (pixels.size() * kLocalShare > s.disparity.size()) return find_discontinuities(s, least, pool);
    for (const std::uint32_t i : pixels) {
        const int x = static_cast<int>(i % s.width), y = static_cast<int>(i / s.width);
        for (int u = std::max(0, x - step::kDiscontinuitiesLeft_px);
             u <= std::min(s.width - 1, x + step::kDiscontinuitiesRight_px); ++u)
            find_discontinuities_of_pixel(s, u, y, least);
        for (int v = std::max(0, y - step::kDiscontinuitiesAbove_px);
             v <= std::min(s.height - 1, y + step::kDiscontinuitiesBelow_px); ++v)
            if (v != y) find_discontinuities_of_pixel(s, x, v, least);
    }
}

// Counts, for each column, the pixels with a discontinuity in `rows` rows.
HEXRELIEF_VECTORS void count_columns(const std::uint8_t* flags, int width, int rows,
                                     std::uint8_t* __restrict counts) {
    constexpr int kBoth = step::kDiscontinuityRight | step::kDiscontinuityDown;
    std::fill_n(counts, width, std::uint8_t{0});
    for (int row = 0; row < rows; ++row, flags += width)
        for (int x = 0; x < width; ++x)
            counts[x] = static_cast<std::uint8_t>(counts[x] + ((flags[x] & kBoth) != 0));
}

// Counts the pixels with a discontinuity by tiles and builds the 2D prefix sums.
void sum_tiles(PixelSurfaces& s, ThreadPool& pool) {
    constexpr int kTile = step::kTile_px;
    const int columns = step::tile_sum_count(s.width), rows = step::tile_sum_count(s.height);
    s.tile_columns = columns;
    s.tile_sums.resize(static_cast<std::size_t>(columns) * rows);
    std::fill_n(s.tile_sums.begin(), columns, 0u);
    pool.parallel_for(static_cast<std::size_t>(rows - 1), [&](std::size_t first, std::size_t last) {
        std::vector<std::uint8_t> counts(static_cast<std::size_t>(columns) * kTile);
        for (std::size_t r = first; r < last; ++r) {
            const int y = static_cast<int>(r) * kTile;
            count_columns(&s.flags[static_cast<std::size_t>(y) * s.width], s.width,
                          std::min(kTile, s.height - y), counts.data());
            std::uint32_t* const sums = &s.tile_sums[(r + 1) * columns];
            sums[0] = 0;
            for (int tile = 0; tile + 1 < columns; ++tile) {
                const std::uint8_t* const own = &counts[static_cast<std::size_t>(tile) * kTile];
                sums[tile + 1] = std::accumulate(own, own + kTile, sums[tile]);
            }
        }
    });
    pool.parallel_for(static_cast<std::size_t>(columns), [&](std::size_t first, std::size_t last) {
        for (int row = 1; row < rows; ++row) {
            std::uint32_t* const sums = &s.tile_sums[static_cast<std::size_t>(row) * columns];
            const std::uint32_t* const above = sums - columns;
            for (std::size_t i = first; i < last; ++i) sums[i] += above[i];
        }
    });
}

}  // namespace

bool PixelSurfaces::may_meet(const Vec2f& a, const Vec2f& b) const {
    const auto pixel = [](float at, int size) { return std::clamp(static_cast<int>(at), 0, size - 1); };
    const int x0 = pixel(std::min(a.x, b.x) - step::kRounding_px, width),
              x1 = pixel(std::max(a.x, b.x) + step::kRounding_px, width),
              y0 = pixel(std::min(a.y, b.y) - step::kRounding_px, height),
              y1 = pixel(std::max(a.y, b.y) + step::kRounding_px, height);
    std::uint64_t any = 0;
    for (int x = x0; x <= x1; x += 8) {
        const std::uint8_t* row = flags.data() + static_cast<std::size_t>(y0) * width + x;
        std::uint64_t eight = 0;
        for (int y = y0; y <= y1; ++y, row += width) eight |= eight_flags(row);
        any |= eight & first_of_eight(x1 + 1 - x);
    }
    return (any & kCracksOfEight) != 0;
}

PixelSurfaces find_pixel_surfaces(const DisparityMap& map, float background_px, double cell_px,
                                  const SurfaceConfig& config, ThreadPool& pool) {
    PixelSurfaces s{map.width, map.height, 0, {}, {}, 0, {}};
    s.disparity.resize(map.values.size());
    s.flags.resize(map.values.size() + PixelSurfaces::kMoreFlags);
    std::fill_n(s.flags.end() - PixelSurfaces::kMoreFlags, PixelSurfaces::kMoreFlags, std::uint8_t{0});
    pool.parallel_for(s.disparity.size(), [&](std::size_t first, std::size_t last) {
        float* const d = s.disparity.data();
        const float* const from = map.values.data();
        const float least = background_px;
        for (std::size_t i = first; i < last; ++i) d[i] = step::foreground(from[i], least);
        std::fill(s.flags.data() + first, s.flags.data() + last, step::kTrusted);
    });
    s.discontinuity_px = config.least_discontinuity_px > 0 ? static_cast<float>(config.least_discontinuity_px)
                                                           : step::kDiscontinuity_px;
    const float least = config.discontinuities == Discontinuities::bridge
                            ? std::numeric_limits<float>::infinity()
                            : s.discontinuity_px;
    settle_half_occlusions(s, least, pool);
    // comes first, so that surfaces torn apart by holes do not become speckles
    absorb_holes(s, cell_px, pool);
    find_discontinuities(s, least, pool);
    find_discontinuities_again(s, absorb_speckles(s, step::kLeastRegion_px, pool), least, pool);
    sum_tiles(s, pool);
    return s;
}

}  // namespace hexrelief::surface
