#include "pipeline/matching/refine/smooth.h"

#include <algorithm>

#include "pipeline/matching/common/color_rows.h"
#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/refine/slopes.h"
#include "pipeline/matching/refine/smooth_step.h"

namespace hexrelief::matching {
namespace {

struct SmoothViews {
    DisparityView map, slope_x, slope_y;
    ColorView colors;
};

using Word = std::uint16_t;

struct Sums {
    std::uint32_t offs[kBlock] = {};
    Word weights[kBlock] = {};
};

// Adds the pixels (i, j) * stride px away.
HEXRELIEF_INLINED void add_pixels(const SmoothViews& in, int stride, int i, int j, int x0, int y, int count,
                                  Sums& sums) {
    const auto dx = static_cast<std::int16_t>(i * stride), dy = static_cast<std::int16_t>(j * stride);
    const auto kernel = step::smoothing_kernel<Word>(i, j);
    const std::int16_t *own = in.map.row(y) + x0, *own_x = in.slope_x.row(y) + x0,
                       *own_y = in.slope_y.row(y) + x0;
    const std::int16_t *other = in.map.row(y + dy) + x0 + dx, *other_x = in.slope_x.row(y + dy) + x0 + dx,
                       *other_y = in.slope_y.row(y + dy) + x0 + dx;
    std::uint8_t steps[kBlock];
    color_steps(in.colors, x0, y, dx, dy, count, steps);
    for (int x = 0; x < count; ++x) {
        const auto change =
            step::plane_change<std::int16_t>(static_cast<std::int16_t>(own_x[x] + other_x[x]),
                                             static_cast<std::int16_t>(own_y[x] + other_y[x]), dx, dy);
        const auto off =
            static_cast<Word>(step::kSmoothReach + step::off_plane<std::int16_t>(own[x], other[x], change));
        const bool alike = (steps[x] <= step::kSmoothColor) & (other[x] >= 0);
        step::SmoothSums<Word> both{sums.weights[x], sums.offs[x]};
        both.add(kernel, step::nearness(off) & step::mask_of<Word>(alike), off);
        sums.weights[x] = both.weights;
        sums.offs[x] = both.offs;
    }
}

HEXRELIEF_SMALL_VECTORS void smooth_row(const SmoothViews& in, int stride, int y,
                                        std::int16_t* __restrict out) {
    for (int x0 = 0; x0 < in.map.width; x0 += kBlock) {
        const int count = std::min(kBlock, in.map.width - x0);
        Sums sums;
        for (int j = -step::kSmoothRadius; j <= step::kSmoothRadius; ++j)
            for (int i = -step::kSmoothRadius; i <= step::kSmoothRadius; ++i)
                add_pixels(in, stride, i, j, x0, y, count, sums);
        const std::int16_t* own = in.map.row(y) + x0;
        for (int x = 0; x < count; ++x) out[x0 + x] = step::smoothed(own[x], sums.offs[x], sums.weights[x]);
    }
}

}  // namespace

Disparities16 smoothed(const Disparities16& map, const ColorPlanes& colors, ThreadPool& pool) {
    const Slopes slopes = find_slopes(map, pool);
    Disparities16 result = map;
    for (int level = 0; level < step::kSmoothLevels; ++level) {
        const Disparities16 before = result;
        const SmoothViews views{before.view(), slopes.x.view(), slopes.y.view(), view_of(colors)};
        for_each_row(pool, map.height(),
                     [&](int y) { smooth_row(views, 1 << level, y, result.view().row(y)); });
    }
    return result;
}

}  // namespace hexrelief::matching
