// Crack edges, the pixel sides with a depth discontinuity, and the silhouette that they form.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "mesher/common/surface_thresholds_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

inline constexpr std::uint8_t kDiscontinuityRight = 1;  // a discontinuity to the pixel on the right
inline constexpr std::uint8_t kDiscontinuityDown = 2;   // a discontinuity to the pixel below
inline constexpr std::uint8_t kTrusted = 4;  // the pixel's disparity is its own, not taken from a neighbour

// Moves a coordinate by an offset rounded to a multiple of 1 / kPositionSteps px, so that floats hold the sum
// exactly up to 16,384 px. Only offsets, never coordinates, are rounded: so a part of a map, which has
// coordinates of its own, is cut into the same triangles as the whole map.
HEXRELIEF_HD float moved_by(float place, float offset_px) {
    const float steps = offset_px * kPositionSteps, half = steps < 0 ? -0.5f : 0.5f;
    return place + static_cast<float>(static_cast<int>(steps + half)) / kPositionSteps;
}

// Returns the largest integer not above `value`.
HEXRELIEF_HD int floor_of(float value) {
    const int whole = static_cast<int>(value);
    return whole - static_cast<int>(static_cast<float>(whole) > value);
}

// Returns the index of the pixel at an offset from a coordinate.
HEXRELIEF_HD int pixel_at(float place, float offset_px) {
    const int own = floor_of(place);
    return own + floor_of(place - static_cast<float>(own) + offset_px);
}

// The map that the surface stage works on, without ownership.
struct PixelView {
    int width, height;
    const float* disparity;     // px, 0 = no foreground
    const std::uint8_t* flags;  // kDiscontinuityRight | kDiscontinuityDown | kTrusted

    HEXRELIEF_HD std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};

// True if neighbouring pixels with these disparities lie on two surfaces. `least`, px, allows for the slope
// that both cameras see, a pixel per pixel, and for quantisation. Disparities are >= 0. Without branches, so
// that loops over rows of pixels vectorise.
HEXRELIEF_HD bool is_discontinuity(float a, float b, float least) {
    const float difference = a - b;
    return ((a > 0) != (b > 0)) | (difference > least) | (-difference > least);
}

// A pixel side: between (x, y) and its right (down = 0) or lower (down = 1) neighbour. It is a crack edge if
// a discontinuity lies on it.
struct Crack {
    int x, y, down;
    friend HEXRELIEF_HD bool operator==(const Crack& a, const Crack& b) {
        return a.x == b.x && a.y == b.y && a.down == b.down;
    }
};

// A point of a silhouette with its normal.
struct SilhouettePoint {
    float x, y;    // px
    float nx, ny;  // unit, towards the nearer surface
};

// True if a discontinuity lies on a side of a pixel of the map. View: PixelView or another type
// with index() and flags.
template <typename View>
HEXRELIEF_HD bool is_crack(const View& map, const Crack& c) {
    return (map.flags[map.index(c.x, c.y)] & (c.down ? kDiscontinuityDown : kDiscontinuityRight)) != 0;
}
// Returns the same for any pixel; false outside the map.
template <typename View>
HEXRELIEF_HD bool has_crack(const View& map, const Crack& c) {
    if (c.x < 0 || c.y < 0 || c.x >= map.width || c.y >= map.height) return false;
    return is_crack(map, c);
}

// True if the pixel itself is nearer than its right or lower neighbour.
HEXRELIEF_HD bool near_is_first(const PixelView& map, const Crack& c) {
    const std::size_t i = map.index(c.x, c.y);
    return map.disparity[i] > map.disparity[c.down ? i + map.width : i + 1];
}

// px
struct Middle {
    float x, y;
};

HEXRELIEF_HD Middle crack_middle(const Crack& c) {
    const float x = static_cast<float>(c.x), y = static_cast<float>(c.y);
    return c.down ? Middle{x + 0.5f, y + 1.0f} : Middle{x + 1.0f, y + 0.5f};
}

// A crack edge whose silhouette point is wanted.
struct SilhouetteCrack {
    Crack crack;
    float x, y;          // its midpoint, px
    bool near_is_first;  // see near_is_first()
};

HEXRELIEF_HD SilhouetteCrack silhouette_crack(const PixelView& map, const Crack& c) {
    const Middle middle = crack_middle(c);
    return {c, middle.x, middle.y, near_is_first(map, c)};
}

// Weighted sums over the crack edges around one.
struct SilhouetteSums {
    float weight = 0, x = 0, y = 0, nx = 0, ny = 0;

    HEXRELIEF_HD void add(const SilhouetteSums& o) {
        weight += o.weight;
        x += o.x;
        y += o.y;
        nx += o.nx;
        ny += o.ny;
    }
};

// Returns what the crack edge right of (down = 0) or below (down = 1) pixel (u, v) adds to the sums. One of
// the same direction whose nearer pixel is on the other side belongs to another silhouette and adds 0.
HEXRELIEF_HD SilhouetteSums silhouette_term(const PixelView& map, const SilhouetteCrack& own, int u, int v,
                                            int down) {
    const Crack o{u, v, down};
    const bool first = near_is_first(map, o);
    if (down == own.crack.down && first != own.near_is_first) return {};
    const Middle middle = crack_middle(o);
    const float ox = middle.x - own.x, oy = middle.y - own.y;
    const float reach = static_cast<float>(kSilhouetteReach_px) + kSilhouetteFade_px;
    const float r = 1 - (ox * ox + oy * oy) / (reach * reach);
    if (!(r > 0)) return {};
    const float w = r * r, towards = first ? -w : w;
    return {w, w * ox, w * oy, down ? 0.0f : towards, down ? towards : 0.0f};
}

// Returns the silhouette point of a crack edge: its midpoint, projected onto the line that the sums describe.
HEXRELIEF_HD SilhouettePoint silhouette_point_of(const SilhouetteCrack& own, SilhouetteSums sums) {
    const float length = std::sqrt(sums.nx * sums.nx + sums.ny * sums.ny);
    if (!(length > kLeastNormal * sums.weight)) {
        const float towards = own.near_is_first ? -1.0f : 1.0f;
        return {own.x, own.y, own.crack.down ? 0.0f : towards, own.crack.down ? towards : 0.0f};
    }
    const float nx = sums.nx / length, ny = sums.ny / length;
    const float off = (sums.x * nx + sums.y * ny) / sums.weight;
    return {moved_by(own.x, off * nx), moved_by(own.y, off * ny), nx, ny};
}

// Returns the side between neighbouring pixels; (dx, dy) is one of (1, 0), (-1, 0), (0, 1), (0, -1).
HEXRELIEF_HD Crack crack_between(int x, int y, int dx, int dy) {
    return {dx < 0 ? x - 1 : x, dy < 0 ? y - 1 : y, dy != 0};
}

// A straight path over the pixels, in steps of at most half a pixel.
struct Way {
    float x, y, dx, dy;
    int steps;
};

HEXRELIEF_HD Way way_between(float ax, float ay, float bx, float by) {
    const float dx = bx - ax, dy = by - ay;
    return {ax, ay, dx, dy, static_cast<int>(2 * std::sqrt(dx * dx + dy * dy)) + 1};
}

struct Pixel {
    int x, y;
};

// Returns the pixel after k steps, 0 <= k <= steps.
template <typename View>
HEXRELIEF_HD Pixel pixel_after(const View& map, const Way& way, int k) {
    const float t = static_cast<float>(k) / static_cast<float>(way.steps);
    return {clamp_to(pixel_at(way.x, t * way.dx), 0, map.width - 1),
            clamp_to(pixel_at(way.y, t * way.dy), 0, map.height - 1)};
}

// True if a discontinuity lies between two successive pixels of a path, which goes sideways first, then up or
// down. met: the first such discontinuity.
template <typename View>
HEXRELIEF_HD bool steps_over(const View& map, const Pixel& from, const Pixel& to, Crack& met) {
    if (to.x != from.x) {
        met = crack_between(from.x, from.y, to.x - from.x, 0);
        if (has_crack(map, met)) return true;
    }
    if (to.y == from.y) return false;
    met = crack_between(to.x, from.y, 0, to.y - from.y);
    return has_crack(map, met);
}

// The discontinuity at which a path crosses a silhouette, if it does.
struct Crossing {
    bool found;
    Crack discontinuity;
};

// Returns the share of the way at which a -> b meets the silhouette through p; if they run side by side, the
// share of the point nearest to p.
HEXRELIEF_HD float meet(const SilhouettePoint& p, float ax, float ay, float bx, float by) {
    const float dx = bx - ax, dy = by - ay;
    const float along = dx * p.nx + dy * p.ny, length2 = dx * dx + dy * dy;
    const float nearest = ((p.x - ax) * dx + (p.y - ay) * dy) / length2;
    const bool crosses = along * along > kLeastCrossing * length2;
    return clamp_to(crosses ? ((p.x - ax) * p.nx + (p.y - ay) * p.ny) / along : nearest, 0.0f, 1.0f);
}

}  // namespace hexrelief::step
