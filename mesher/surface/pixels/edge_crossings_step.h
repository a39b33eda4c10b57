// Crossings of straight lines with silhouettes. The Query type reads the pixels through walk(),
// silhouette_point() and nearest_crack(): crack_query.h has one for a single thread, the device
// one for a warp.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

HEXRELIEF_HD float distance(const Vec2f& a, const Vec2f& b) {
    return std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
}

// Returns the point at a share of the way from a to b.
HEXRELIEF_HD Vec2f between(const Vec2f& a, const Vec2f& b, float share) {
    return {moved_by(a.x, share * (b.x - a.x)), moved_by(a.y, share * (b.y - a.y))};
}

// The pixels from (x0, y0) to (x1, y1), both included.
struct PixelWindow {
    int x0, y0, x1, y1;
};

// Returns the pixels of the map within reach_px of p.
HEXRELIEF_HD PixelWindow window_around(const PixelView& map, const Vec2f& p, float reach_px) {
    const int r = static_cast<int>(reach_px) + 1, x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    return {max_of(0, x - r), max_of(0, y - r), min_of(map.width - 1, x + r), min_of(map.height - 1, y + r)};
}

// Returns the squared distance of a crack edge's midpoint from p, px2.
HEXRELIEF_HD float distance2_to(const Crack& c, const Vec2f& p) {
    const Middle middle = crack_middle(c);
    const float dx = middle.x - p.x, dy = middle.y - p.y;
    return dx * dx + dy * dy;
}

// Orders the crack edges of a window's pixels by their distance from a point, equally near ones row by row,
// right before down. A crack edge's rank is lower than those of all that come after it.
class CrackOrder {
  public:
    HEXRELIEF_HD explicit CrackOrder(const PixelWindow& window)
        : window_(window), width_(window.x1 - window.x0 + 1) {}
    // distance2: squared distance of the crack edge from the point, px2.
    HEXRELIEF_HD std::uint64_t rank(const Crack& c, float distance2) const {
        const int place = 2 * ((c.y - window_.y0) * width_ + c.x - window_.x0) + c.down;
        return bits_of(distance2) << 32 | static_cast<std::uint32_t>(place + 1);
    }
    // Returns a value above the ranks of all crack edges nearer than reach_px and below all other ranks.
    HEXRELIEF_HD static std::uint64_t none(float reach_px) { return bits_of(reach_px * reach_px) << 32; }
    HEXRELIEF_HD static float distance2(std::uint64_t rank) {
        const std::uint32_t bits = static_cast<std::uint32_t>(rank >> 32);
#ifdef __CUDA_ARCH__
        return __uint_as_float(bits);
#else
        return std::bit_cast<float>(bits);
#endif
    }
    HEXRELIEF_HD Crack crack(std::uint64_t rank) const {
        const int place = static_cast<int>(rank & 0xffffffffu) - 1, row = place / 2 / width_;
        return {window_.x0 + place / 2 - row * width_, window_.y0 + row, place & 1};
    }

  private:
    // Non-negative floats have the same order as their bits.
    HEXRELIEF_HD static std::uint64_t bits_of(float value) {
#ifdef __CUDA_ARCH__
        return __float_as_uint(value);
#else
        return std::bit_cast<std::uint32_t>(value);
#endif
    }
    PixelWindow window_;
    int width_;
};

// Number of tiles (see TileView) that a window spans horizontally.
HEXRELIEF_HD int tiles_across(const PixelWindow& w) {
    return w.x1 / kTile_px - w.x0 / kTile_px + 1;
}

// Number of tiles that a window spans vertically.
HEXRELIEF_HD int tiles_down(const PixelWindow& w) {
    return w.y1 / kTile_px - w.y0 / kTile_px + 1;
}

// Returns the pixels of a window that lie in one tile; tiles are counted from the window's upper left.
HEXRELIEF_HD PixelWindow tile_of(const PixelWindow& w, int column, int row) {
    const int x = (w.x0 / kTile_px + column) * kTile_px, y = (w.y0 / kTile_px + row) * kTile_px;
    return {max_of(w.x0, x), max_of(w.y0, y), min_of(w.x1, x + kTile_px - 1), min_of(w.y1, y + kTile_px - 1)};
}

// Returns a lower bound, px2, of the squared distance of p from the crack edges of a window's pixels.
HEXRELIEF_HD float least_distance2(const PixelWindow& w, const Vec2f& p) {
    // px from a pixel's upper left corner: the midpoints of its crack edges lie between 0.5 and
    // 1.5; with a margin
    constexpr float kFirstMiddle_px = 0.4f, kLastMiddle_px = 1.6f;
    const float dx = max_of(0.0f, max_of(static_cast<float>(w.x0) + kFirstMiddle_px - p.x,
                                         p.x - static_cast<float>(w.x1) - kLastMiddle_px));
    const float dy = max_of(0.0f, max_of(static_cast<float>(w.y0) + kFirstMiddle_px - p.y,
                                         p.y - static_cast<float>(w.y1) - kLastMiddle_px));
    return dx * dx + dy * dy;
}

// True if the tile of these pixels has a discontinuity and one of its crack edges may lie within
// the distance of p.
HEXRELIEF_HD bool tile_matters(const TileView& tiles, const PixelWindow& w, const Vec2f& p, float distance2) {
    return tiles_hold(tiles, w.x0, w.y0, w.x1, w.y1) && least_distance2(w, p) <= distance2;
}

// Returns where the edge a -> b crosses a silhouette that neither end lies on, as a share of the way; below 0
// if nowhere. forth: true if a is the edge's first vertex; the path over its pixels always starts there.
template <typename Query>
HEXRELIEF_HD float open_crossing(const Query& query, const Vec2f& a, bool a_on_silhouette, const Vec2f& b,
                                 bool b_on_silhouette, bool forth) {
    if (a_on_silhouette && b_on_silhouette) return -1;
    // the discontinuity nearest to a or, if a is on a silhouette, the farthest
    const Crossing crossing = query.walk(forth ? a : b, forth ? b : a, a_on_silhouette == forth);
    if (!crossing.found) return -1;
    const float t = meet(query.silhouette_point(crossing.discontinuity), a.x, a.y, b.x, b.y);
    if (a_on_silhouette) return t > kOnSilhouetteShare ? t : -1;
    return b_on_silhouette && t > 1 - kOnSilhouetteShare ? -1 : t;
}

// Returns the first crossing of the edge a -> b with a silhouette on the way from its midpoint to b, or to a
// if `back`, as a share of the edge; below 0 if there is none.
template <typename Query>
HEXRELIEF_HD float crossing_from_middle(const Query& query, const Vec2f& a, const Vec2f& b, bool back) {
    const Vec2f m{(a.x + b.x) / 2, (a.y + b.y) / 2};
    const Crossing crossing = query.walk(m, back ? a : b, false);
    return crossing.found ? meet(query.silhouette_point(crossing.discontinuity), a.x, a.y, b.x, b.y) : -1;
}

// Returns, of the two shares that crossing_from_middle() found, the one nearer to the midpoint; below
// 0 if both are.
HEXRELIEF_HD float nearer_middle(float back, float forth) {
    if (back < 0 || forth < 0) return forth < 0 ? back : forth;
    return std::fabs(forth - 0.5f) < std::fabs(back - 0.5f) ? forth : back;
}

// Returns the silhouette's point nearest to p, searched up to kNearestBeyond_px beyond the known crossing.
template <typename Query>
HEXRELIEF_HD Vec2f nearest_silhouette(const Query& query, const Vec2f& p, const Vec2f& crossing) {
    const Crack best = query.nearest_crack(p, distance(p, crossing) + kNearestBeyond_px);
    if (best.x < 0) return crossing;
    const SilhouettePoint silhouette = query.silhouette_point(best);
    const float along = clamp_to((p.y - silhouette.y) * silhouette.nx - (p.x - silhouette.x) * silhouette.ny,
                                 -kMostAlong_px, kMostAlong_px);
    return {moved_by(silhouette.x, -along * silhouette.ny), moved_by(silhouette.y, along * silhouette.nx)};
}

}  // namespace hexrelief::step
