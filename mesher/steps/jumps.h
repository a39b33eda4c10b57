// Depth jumps between neighbouring pixels found in a disparity map, and how many lie where.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/steps/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

// Jumps are counted in tiles of so many pixels a side; the sums at (column, row) are those of all tiles left
// of and above it.
inline constexpr int kTile_px = 4;

// Sums along a side of so many pixels.
HEXRELIEF_HD int tile_sum_count(int size_px) {
    return (size_px + kTile_px - 1) / kTile_px + 1;
}

struct TileView {
    int width, height;  // of the map, px
    int columns;        // of the sums
    const std::uint32_t* sums;
};

// Whether a jump lies in or next to the box from a to b.
HEXRELIEF_HD bool may_cross(const TileView& tiles, const Vec2f& a, const Vec2f& b) {
    const auto tile = [](float v, int size) { return clamp_to(static_cast<int>(v), 0, size - 1) / kTile_px; };
    const std::size_t c0 = tile(min_of(a.x, b.x) - 1, tiles.width),
                      c1 = tile(max_of(a.x, b.x), tiles.width) + 1;
    const std::size_t r0 = tile(min_of(a.y, b.y) - 1, tiles.height),
                      r1 = tile(max_of(a.y, b.y), tiles.height) + 1;
    const std::size_t n = static_cast<std::size_t>(tiles.columns);
    return tiles.sums[r1 * n + c1] + tiles.sums[r0 * n + c0] !=
           tiles.sums[r0 * n + c1] + tiles.sums[r1 * n + c0];
}

}  // namespace hexrelief::step
