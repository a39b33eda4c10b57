#include "mesher/surface/pixels/crack_query.h"

#include <bit>
#include <cstdint>

#include "mesher/common/simd.h"
#include "mesher/common/simd_bytes.h"

namespace hexrelief {
namespace {

constexpr int kSteps = 8;  // of a way at a time

// Pixels after steps first .. first + kSteps - 1 of a way, the last one for all beyond.
HEXRELIEF_VECTORS void places_after(const step::PixelView& pixels, const step::Way& way, int first,
                                    int* __restrict xs, int* __restrict ys) {
    const step::Way w = way;
    const struct { int width, height; } map{pixels.width, pixels.height};
    for (int k = 0; k < kSteps; ++k) {
        const step::Pixel at = step::pixel_after(map, w, step::min_of(first + k, w.steps));
        xs[k] = at.x;
        ys[k] = at.y;
    }
}

// Discontinuities right of and below a row's pixels x0 .. x1, at most eight, in their lanes.
std::uint64_t discontinuities_of_row(const step::PixelView& pixels, int y, int x0, int x1) {
    const std::uint8_t* const first = pixels.flags + pixels.index(x0, y);
    return eight_at(first, first + 8) & lanes_of(static_cast<std::size_t>(x1 - x0 + 1)) &
           in_each_lane(step::kDiscontinuityRight | step::kDiscontinuityDown);
}

}  // namespace

// Places and flags before what they say is asked: from step to step no branch could be foreseen.
WayDiscontinuities discontinuities_on(const step::PixelView& pixels, const step::Way& way, bool only_first) {
    WayDiscontinuities discontinuities{};
    int xs[kSteps + 1], ys[kSteps + 1];
    const step::Pixel start = step::pixel_after(pixels, way, 0);
    xs[0] = start.x;
    ys[0] = start.y;
    for (int first = 1; first <= way.steps; first += kSteps) {
        places_after(pixels, way, first, xs + 1, ys + 1);
        unsigned met = 0;
        for (int k = 0; k < kSteps; ++k) {
            const int x0 = xs[k], y0 = ys[k], x1 = xs[k + 1], y1 = ys[k + 1];
            const unsigned across = pixels.flags[pixels.index(step::min_of(x0, x1), y0)] &
                                    step::kDiscontinuityRight,
                           down = pixels.flags[pixels.index(x1, step::min_of(y0, y1))] &
                                  step::kDiscontinuityDown;
            met |= static_cast<unsigned>((x0 != x1 && across) | (y0 != y1 && down)) << k;
        }
        if (met) {
            const auto step_at = [&](int k, step::Crack& discontinuity) {
                step::steps_over(pixels, {xs[k], ys[k]}, {xs[k + 1], ys[k + 1]}, discontinuity);
            };
            if (!discontinuities.found) step_at(std::countr_zero(met), discontinuities.first);
            discontinuities.found = true;
            if (only_first) return discontinuities;
            const int k = std::bit_width(met) - 1;
            step_at(k, discontinuities.last);
            const step::Crack ahead = step::crack_between(xs[k + 1], ys[k], 0, ys[k + 1] - ys[k]);
            if (ys[k] != ys[k + 1] && step::has_crack(pixels, ahead)) discontinuities.last = ahead;
        }
        xs[0] = xs[kSteps];
        ys[0] = ys[kSteps];
    }
    return discontinuities;
}

step::SilhouettePoint PixelLook::silhouette_point(const step::Crack& c) const {
    constexpr int kReach = step::kSilhouetteReach_px, kSide = 2 * kReach + 1;
    static_assert(2 * kSide * kSide <= 64);
    const step::SilhouetteCrack own = step::silhouette_crack(pixels, c);
    const int u0 = step::max_of(0, c.x - kReach), u1 = step::min_of(pixels.width - 1, c.x + kReach);
    std::uint64_t cracks = 0;  // two bits a place, right before down
    for (int row = 0; row < kSide; ++row) {
        const int v = c.y - kReach + row;
        if (v < 0 || v >= pixels.height) continue;
        const std::uint64_t discontinuities = discontinuities_of_row(pixels, v, u0, u1);
        std::uint64_t bits = 0;
        for (int k = 0; k < kSide; ++k) bits |= (discontinuities >> 8 * k & 3u) << 2 * k;
        cracks |= bits << 2 * kSide * row;
    }
    step::SilhouetteSums sums;
    for (; cracks != 0; cracks &= cracks - 1) {
        const int bit = std::countr_zero(cracks), place = bit / 2;
        sums.add(
            step::silhouette_term(pixels, own, u0 + place % kSide, c.y - kReach + place / kSide, bit % 2));
    }
    return step::silhouette_point_of(own, sums);
}

step::Crack PixelLook::nearest_crack(const Vec2f& p, float reach_px) const {
    const step::PixelWindow window = step::window_around(pixels, p, reach_px);
    float least = reach_px * reach_px;
    step::Crack best{-1, -1, 0};
    for (int row = 0; row < step::tiles_down(window); ++row)
        for (int column = 0; column < step::tiles_across(window); ++column) {
            const step::PixelWindow w = step::tile_of(window, column, row);
            if (!step::tile_matters(tiles, w, p, least)) continue;
            for (int y = w.y0; y <= w.y1; ++y)
                for (std::uint64_t discontinuities = discontinuities_of_row(pixels, y, w.x0, w.x1);
                     discontinuities != 0; discontinuities &= discontinuities - 1) {
                    const int bit = std::countr_zero(discontinuities);
                    const step::Crack c{w.x0 + bit / 8, y, bit % 8};
                    const float distance2 = step::distance2_to(pixels, c, p);
                    const bool first = c.y < best.y || (c.y == best.y && c.x < best.x);
                    if ((distance2 > least) | ((distance2 == least) & !first)) continue;
                    least = distance2;
                    best = c;
                }
        }
    return best;
}

}  // namespace hexrelief
