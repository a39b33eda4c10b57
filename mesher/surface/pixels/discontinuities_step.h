// Finds the depth discontinuities between neighbouring pixels of a disparity map, counts them by tiles, and
// tells which are low half-occlusion steps.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/column_slope_step.h"
#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

// True if d is neither infinite nor NaN.
HEXRELIEF_HD bool is_finite(float d) {
    return d - d == 0;
}

// Returns d, or 0 if it is background or unknown. Like the next functions it has no branches,
// so that loops vectorise.
HEXRELIEF_HD float foreground(float d, float background_px) {
    return is_finite(d) & (d > 0) & !(d < background_px) ? d : 0.0f;
}

// True if the step from d[0] to d[next] is higher than kLowStep_px or the steepest part, and the first of
// equal ones, of a step that is spread over several pixels: then it may be a discontinuity. before, after:
// true if there are pixels at -next and at 2 * next.
HEXRELIEF_HD bool is_steepest(const float* d, std::ptrdiff_t next, bool before, bool after) {
    const float own = d[0], other = d[next], first = before ? d[-next] : 0, last = after ? d[2 * next] : 0;
    const float step = other - own, height = distance(own, other);
    if (!(own > 0) || !(other > 0) || height > kLowStep_px) return true;
    const bool before_is_stronger =
        first > 0 && (own - first > 0) == (step > 0) && distance(first, own) >= height;
    const bool after_is_stronger =
        last > 0 && (last - other > 0) == (step > 0) && distance(other, last) > height;
    return !before_is_stronger && !after_is_stronger;
}

// Returns kDiscontinuityRight | kDiscontinuityDown for the steps from a pixel to its right and lower
// neighbours. For the last pixel of a row or column, pass its own disparity as the neighbour's.
HEXRELIEF_HD int steps_at(float d, float right, float below, float least) {
    return (is_discontinuity(d, right, least) ? kDiscontinuityRight : 0) |
           (is_discontinuity(d, below, least) ? kDiscontinuityDown : 0);
}

// True if the step at c is a discontinuity; d points to the disparity of its pixel.
HEXRELIEF_HD bool is_discontinuity_of_step(const float* d, const Crack& c, int width, int height,
                                           float least) {
    const std::ptrdiff_t next = c.down ? width : 1;
    const int before = c.down ? c.y : c.x, after = c.down ? height - 2 - c.y : width - 2 - c.x;
    return is_steepest(d, next, before > 0, after > 0) &&
           !(c.down && is_slope(d, next, before, after, least));
}

// Reach of a change: the disparity at (x, y) affects the discontinuities of its row from x - 2 to x + 1, and
// of its column from y - kLineReach_px to y + kLineReach_px - 1.
inline constexpr int kDiscontinuitiesLeft_px = 2, kDiscontinuitiesRight_px = 1;
inline constexpr int kDiscontinuitiesAbove_px = kLineReach_px, kDiscontinuitiesBelow_px = kLineReach_px - 1;
static_assert(kSlopeReach_px < kLineReach_px);

// The two kinds of regions that take a disparity from their surroundings. A hole is mostly what the other
// camera does not see, a part of the farther surface around it. A speckle is an error on the nearer surface.
enum class Around { hole, speckle };

// Start value for taken(), which loses against any disparity.
HEXRELIEF_HD float nothing(Around kind) {
    return kind == Around::hole ? 3.4e38f : -1.0f;
}
// Returns the disparity, of two around a hole or speckle, that the region takes: the smaller for a hole, the
// larger for a speckle.
HEXRELIEF_HD float taken(float a, float b, Around kind) {
    return kind == Around::hole ? min_of(a, b) : max_of(a, b);
}

// Discontinuities are counted in square tiles of kTile_px pixels a side; the sum at (column, row) counts all
// tiles left of and above it.
inline constexpr int kTile_px = 4;

// Returns the number of sums along a side of size_px pixels.
HEXRELIEF_HD int tile_sum_count(int size_px) {
    return (size_px + kTile_px - 1) / kTile_px + 1;
}

// The sums of the tiles' counts, without ownership.
struct TileView {
    int width, height;  // of the map, px
    int columns;        // columns of `sums`
    const std::uint32_t* sums;
};

// True if a discontinuity lies in the tiles of the pixels (x0, y0) to (x1, y1), both included.
HEXRELIEF_HD bool tiles_hold(const TileView& tiles, int x0, int y0, int x1, int y1) {
    const std::size_t n = static_cast<std::size_t>(tiles.columns);
    const std::size_t c0 = x0 / kTile_px, c1 = x1 / kTile_px + 1;
    const std::size_t r0 = n * (y0 / kTile_px), r1 = n * (y1 / kTile_px + 1);
    return tiles.sums[r1 + c1] + tiles.sums[r0 + c0] != tiles.sums[r0 + c1] + tiles.sums[r1 + c0];
}

// True if a discontinuity lies in the tiles in or next to the box from a to b.
HEXRELIEF_HD bool may_cross(const TileView& tiles, const Vec2f& a, const Vec2f& b) {
    const auto pixel = [](float v, int size) { return clamp_to(static_cast<int>(v), 0, size - 1); };
    return tiles_hold(tiles, pixel(min_of(a.x, b.x) - 1, tiles.width),
                      pixel(min_of(a.y, b.y) - 1, tiles.height), pixel(max_of(a.x, b.x), tiles.width),
                      pixel(max_of(a.y, b.y), tiles.height));
}

// True if the step between two neighbours of a row is a low half-occlusion step: from near to far, left to
// right. Beside it lies a strip of the farther surface, a few pixels wide, that only the right camera sees. A
// nearer surface that reaches a little too far, or a fit that rounds the step, would hide the strip.
HEXRELIEF_HD bool is_low_half_occlusion(float left, float right) {
    return (right > 0) & (left > right) & (left - right < kLowHalfOcclusion_px);
}

// True if the last discontinuity to the left of (x, y), within kHalfOcclusionReach_px, is
// a low half-occlusion step.
HEXRELIEF_HD bool is_behind_low_half_occlusion(const PixelView& view, int x, int y) {
    const std::size_t i = view.index(x, y);
    for (int k = 1; k <= kHalfOcclusionReach_px && k <= x; ++k) {
        if (!(view.flags[i - k] & kDiscontinuityRight)) continue;
        return is_low_half_occlusion(view.disparity[i - k], view.disparity[i - k + 1]);
    }
    return false;
}

// True if a discontinuity to the right neighbour lies among pixels first .. end - 1 of a row or shortly
// before them; otherwise none of them is behind a half-occlusion step.
HEXRELIEF_HD bool has_discontinuity_before(const PixelView& view, int y, int first, int end) {
    const std::uint8_t* const flags = view.flags + view.index(0, y);
    std::uint8_t any = 0;
    for (int x = max_of(0, first - kHalfOcclusionReach_px); x < end; ++x) any |= flags[x];
    return (any & kDiscontinuityRight) != 0;
}

// Returns the disparity of a pixel after low steps of single-pixel width are removed. A pixel between two
// half-occlusion steps, on its left and right, takes the disparity on its right, that of the farther surface:
// maps have such pixels where a silhouette runs through a pixel's middle, and no triangle is as narrow. All
// others keep their own disparity, and so do parts of longer slopes. The arguments are the row's disparities
// up to two pixels away, 0 beyond its ends.
HEXRELIEF_HD float between_half_occlusions(float before2, float before, float own, float after, float after2,
                                           float least) {
    const bool half_occlusions = (after > 0) & (before - own > least) & (own - after > least),
               low = own - after < kLowHalfOcclusion_px,
               goes_on = (before2 - before > least) | ((after2 > 0) & (after - after2 > least));
    return half_occlusions & low & !goes_on ? after : own;
}

}  // namespace hexrelief::step
