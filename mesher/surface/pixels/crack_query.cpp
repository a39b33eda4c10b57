#include "mesher/surface/pixels/crack_query.h"

#include <algorithm>
#include <cstdint>

#include "mesher/surface/pixels/eight_flags.h"

namespace hexrelief::surface {

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
        // sideways first, then up or down; reading both flags before testing either saves branches
        const int across =
                      pixels.flags[pixels.index(std::min(from.x, to.x), from.y)] & step::kDiscontinuityRight,
                  down = pixels.flags[pixels.index(to.x, std::min(from.y, to.y))] & step::kDiscontinuityDown;
        const bool meets_across = (to.x != from.x) & (across != 0),
                   meets_down = (to.y != from.y) & (down != 0);
        if (meets_across) look_at(step::crack_between(from.x, from.y, to.x - from.x, 0));
        if (meets_down && !(only_first && discontinuities.found))
            look_at(step::crack_between(to.x, from.y, 0, to.y - from.y));
        if (only_first && discontinuities.found) break;
        from = to;
    }
    return discontinuities;
}

step::SilhouettePoint CrackQuery::silhouette_point(const step::Crack& c) const {
    constexpr int kReach = step::kSilhouetteReach_px;
    const step::SilhouetteCrack own = step::silhouette_crack(pixels, c);
    step::SilhouetteSums sums;
    const int x0 = std::max(0, c.x - kReach), x1 = std::min(pixels.width - 1, c.x + kReach);
    for (int y = std::max(0, c.y - kReach); y <= std::min(pixels.height - 1, c.y + kReach); ++y)
        each_crack(pixels, y, x0, x1 + 1, [&](const step::Crack& other) {
            sums.add(step::silhouette_term(pixels, own, other.x, other.y, other.down));
        });
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
                each_crack(pixels, y, w.x0, w.x1 + 1, [&](const step::Crack& c) {
                    first = std::min(first, order.rank(c, step::distance2_to(c, p)));
                });
        }
    return first == none ? step::Crack{-1, -1, 0} : order.crack(first);
}

}  // namespace hexrelief::surface
