#include "mesher/surface/pixels/crack_query.h"

#include <algorithm>
#include <cstdint>

namespace hexrelief {

WayDiscontinuities discontinuities_on(const step::PixelView& pixels, const step::Way& way, bool only_first) {
    WayDiscontinuities discontinuities{};
    const auto look_at = [&](const step::Crack& c) {
        if (!discontinuities.found) discontinuities.first = c;
        discontinuities.last = c;
        discontinuities.found = true;
    };
    step::Pixel from = step::pixel_after(pixels, way, 0);
    for (int k = 1; k <= way.steps; ++k) {
        const step::Pixel to = step::pixel_after(pixels, way, k);
        // to the side first, then up or down; both are read before either is tested, which saves branches
        const step::Crack across = step::crack_between(from.x, from.y, to.x - from.x, 0),
                          down = step::crack_between(to.x, from.y, 0, to.y - from.y);
        const bool meets_across = (to.x != from.x) & step::is_crack(pixels, across),
                   meets_down = (to.y != from.y) & step::is_crack(pixels, down);
        if (meets_across) look_at(across);
        if (meets_down && !(only_first && discontinuities.found)) look_at(down);
        if (only_first && discontinuities.found) break;
        from = to;
    }
    return discontinuities;
}

step::SilhouettePoint CrackQuery::silhouette_point(const step::Crack& c) const {
    constexpr int kReach = step::kSilhouetteReach_px;
    const step::SilhouetteCrack own = step::silhouette_crack(pixels, c);
    step::SilhouetteSums sums;
    for (int y = step::max_of(0, c.y - kReach); y <= step::min_of(pixels.height - 1, c.y + kReach); ++y)
        for (int x = step::max_of(0, c.x - kReach); x <= step::min_of(pixels.width - 1, c.x + kReach); ++x)
            for (int down = 0; down < 2; ++down)
                if (step::has_crack(pixels, {x, y, down}))
                    sums.add(step::silhouette_term(pixels, own, x, y, down));
    return step::silhouette_point_of(own, sums);
}

step::Crack CrackQuery::nearest_crack(const Vec2f& p, float reach_px) const {
    const step::PixelWindow window = step::window_around(pixels, p, reach_px);
    const step::CrackOrder order(window);
    const std::uint64_t none = order.none(reach_px);
    std::uint64_t first = none;
    for (int row = 0; row < step::tiles_down(window); ++row)
        for (int column = 0; column < step::tiles_across(window); ++column) {
            const step::PixelWindow w = step::tile_of(window, column, row);
            if (!step::tile_matters(tiles, w, p, order.distance2(first))) continue;
            for (int y = w.y0; y <= w.y1; ++y)
                for (int x = w.x0; x <= w.x1; ++x)
                    for (int down = 0; down < 2; ++down)
                        if (const step::Crack c{x, y, down}; step::is_crack(pixels, c))
                            first = std::min(first, order.rank(c, step::distance2_to(pixels, c, p)));
        }
    return first == none ? step::Crack{-1, -1, 0} : order.crack(first);
}

}  // namespace hexrelief
