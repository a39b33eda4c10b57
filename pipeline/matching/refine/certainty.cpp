#include "pipeline/matching/refine/certainty.h"

#include <algorithm>
#include <vector>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/refine/match_colors.h"
#include "pipeline/matching/refine/slope_step.h"

namespace hexrelief::matching {
namespace {

// The sides of the discontinuities in each column of a row of blocks.
struct ColumnSides {
    std::vector<std::int16_t> farthest, nearest;
};

// Adds the pixels of a row.
HEXRELIEF_SMALL_VECTORS void add_row(DisparityView map, int y, ColumnSides& sides) {
    const std::int16_t* const row = map.row(y);
    std::int16_t *const farthest = sides.farthest.data(), *const nearest = sides.nearest.data();
    for (int x = 0; x < map.width; ++x) {
        const std::int16_t is_side = step::mask_of(step::beside_discontinuity(row + x, map.stride));
        const auto far = static_cast<std::int16_t>(is_side ? row[x] : step::no_sides().farthest);
        const auto near = static_cast<std::int16_t>(is_side ? row[x] : step::no_sides().nearest);
        farthest[x] = std::min(farthest[x], far);
        nearest[x] = std::max(nearest[x], near);
    }
}

// The sides of each block's discontinuities, widened by those of the blocks around it.
Raster<step::Sides> sides_of_blocks(const Disparities16& map, ThreadPool& pool) {
    constexpr int kSide = step::kSidesBlock_px;
    const DisparityView view = map.view();
    const auto width = static_cast<std::size_t>(view.width);
    const int columns = (view.width + kSide - 1) / kSide, rows = (view.height + kSide - 1) / kSide;
    Raster<step::Sides> own(columns, rows, step::no_sides()), wide = own;
    for_each_row(pool, rows, [&](int row) {
        ColumnSides sides{std::vector(width, step::no_sides().farthest),
                          std::vector(width, step::no_sides().nearest)};
        for (int y = row * kSide; y < std::min((row + 1) * kSide, view.height); ++y) add_row(view, y, sides);
        for (std::size_t x = 0; x < width; ++x) {
            step::Sides& block = own.view().row(row)[x / kSide];
            block = step::both(block, {sides.farthest[x], sides.nearest[x]});
        }
    });
    for_each_row(pool, rows, [&](int row) {
        for (int column = 0; column < columns; ++column)
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    wide.view().at(column, row) =
                        step::both(wide.view().at(column, row), own.view().at(column + i, row + j));
    });
    return wide;
}

}  // namespace

Raster<step::Certainty> find_certainty(const CertaintyInput& input, ThreadPool& pool) {
    const DisparityView map = input.map.view();
    const ColorView left = view_of(input.colors.left), right = view_of(input.colors.right);
    const Raster<step::Sides> sides = sides_of_blocks(input.map, pool);
    Raster<step::Certainty> result(map.width, map.height, step::Certainty::right);
    for_each_row(pool, map.height, [&](int y) {
        const step::Sides* const row = sides.view().row(y / step::kSidesBlock_px);
        for (int x = 0; x < map.width; ++x) {
            const step::Sides& here = row[x / step::kSidesBlock_px];
            if (here.nearest < 0) continue;
            const step::RowSite site{x, map.width, input.min_px, input.nearest_seen.view().row(y)};
            result.view().at(x, y) = step::certainty(site, map.at(x, y), here, [&](int disparity) {
                return match_difference(left, right, x, y,
                                        step::position_in_right(x, input.min_px, disparity));
            });
        }
    });
    return result;
}

}  // namespace hexrelief::matching
