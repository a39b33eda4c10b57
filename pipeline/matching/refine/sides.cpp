#include "pipeline/matching/refine/sides.h"

#include <algorithm>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/refine/match_colors.h"
#include "pipeline/matching/refine/side_step.h"

namespace hexrelief::matching {
namespace {

struct SideViews {
    DisparityView map;
    ColorView left, right;
    RasterView<const std::int32_t> nearest_seen;
    int min_px;
};

HEXRELIEF_SMALL_VECTORS void find_sides(DisparityView map, int x0, int y, int count,
                                        step::Sides* __restrict sides) {
    const std::int16_t* row = map.row(y) + x0;
    for (int x = 0; x < count; ++x) sides[x] = step::sides_at(row + x, map.stride);
}

void choose_in_row(const SideViews& in, int y, std::int16_t* out) {
    const std::int16_t* row = in.map.row(y);
    step::Sides sides[kBlock];
    for (int x0 = 0; x0 < in.map.width; x0 += kBlock) {
        const int count = std::min(kBlock, in.map.width - x0);
        find_sides(in.map, x0, y, count, sides);
        for (int x = x0; x < x0 + count; ++x) {
            const step::Sides& here = sides[x - x0];
            if (!step::discontinuous(row[x], here.farthest) && !step::discontinuous(row[x], here.nearest))
                continue;
            const step::RowSite site{x, in.map.width, in.min_px, in.nearest_seen.row(y)};
            out[x] = step::better_side(site, row[x], here, [&](int disparity) {
                return match_difference(in.left, in.right, x, y,
                                        step::position_in_right(x, in.min_px, disparity));
            });
        }
    }
}

}  // namespace

Disparities16 choose_sides(const SideInput& input, ThreadPool& pool) {
    Disparities16 result = input.map;
    const SideViews views{input.map.view(), view_of(input.left), view_of(input.right),
                          input.nearest_seen.view(), input.min_px};
    for_each_row(pool, result.height(), [&](int y) { choose_in_row(views, y, result.view().row(y)); });
    return result;
}

}  // namespace hexrelief::matching
