#include "pipeline/matching/refine/slopes.h"

#include <algorithm>

#include "pipeline/base/simd.h"
#include "pipeline/matching/refine/slope_step.h"
#include "pipeline/matching/refine/smooth_step.h"

namespace hexrelief::matching {
namespace {

using Word = std::uint16_t;

struct LineSums {
    Word on[kBlock], v[2][kBlock] = {}, tv[2][kBlock] = {};
};

// Fits lines at pixels[0 .. count - 1], along x (along = 1) or y (along = stride).
HEXRELIEF_INLINED void fit_lines(const std::int16_t* pixels, std::ptrdiff_t along, int count,
                                 std::int16_t* __restrict slopes) {
    LineSums s;
    for (int side = 0; side < 2; ++side) {
        const std::ptrdiff_t onward = side == 0 ? -along : along;
        Word *const v = s.v[side], *const tv = s.tv[side];
        for (int x = 0; x < count; ++x) s.on[x] = pixels[x] >= 0;
        for (int k = 1; k <= step::kSamples; ++k) {
            const std::int16_t *here = pixels + k * onward, *before = here - onward;
            for (int x = 0; x < count; ++x) {
                step::SideSums<Word> sums{s.on[x], v[x], tv[x]};
                sums.add(static_cast<unsigned>(k), static_cast<Word>(here[x] | step::kUnknownBit),
                         static_cast<Word>(before[x] & ~step::kUnknownBit), static_cast<Word>(pixels[x]));
                s.on[x] = sums.on;
                v[x] = sums.v;
                tv[x] = sums.tv;
            }
        }
    }
    for (int x = 0; x < count; ++x) {
        const step::SideSum before(s.v[0][x]), behind(s.v[1][x]), t_before(s.tv[0][x]), t_behind(s.tv[1][x]);
        slopes[x] =
            static_cast<std::int16_t>(step::line_slope(step::LinePlaces(before.count, behind.count),
                                                       before.sum + behind.sum, t_behind.sum - t_before.sum));
    }
}

HEXRELIEF_SMALL_VECTORS void fit_row(DisparityView map, int y, Slopes& slopes) {
    for (int x = 0; x < map.width; x += kBlock) {
        const int count = std::min(kBlock, map.width - x);
        fit_lines(map.row(y) + x, 1, count, slopes.x.view().row(y) + x);
        fit_lines(map.row(y) + x, map.stride, count, slopes.y.view().row(y) + x);
    }
}

struct SlopeViews {
    DisparityView x, y;
};

HEXRELIEF_INLINED void average_block(DisparityView map, const SlopeViews& slopes, int stride_px, int x0,
                                     int y, int count, Slopes& means) {
    std::int16_t n[kBlock] = {}, sum_x[kBlock] = {}, sum_y[kBlock] = {};
    const std::int16_t* own = map.row(y) + x0;
    for (int j = -step::kSlopeRadius; j <= step::kSlopeRadius; ++j)
        for (int i = -step::kSlopeRadius; i <= step::kSlopeRadius; ++i) {
            if (!step::is_dark(i, j)) continue;
            const int dx = i * stride_px, dy = j * stride_px;
            const std::int16_t* other = map.row(y + dy) + x0 + dx;
            const std::int16_t *slope_x = slopes.x.row(y + dy) + x0 + dx,
                               *slope_y = slopes.y.row(y + dy) + x0 + dx;
            for (int x = 0; x < count; ++x) {
                const std::int16_t on =
                    step::mask_of((other[x] >= 0) & step::is_same_surface(other[x], own[x]));
                n[x] = static_cast<std::int16_t>(n[x] - on);
                sum_x[x] = static_cast<std::int16_t>(sum_x[x] + (slope_x[x] & on));
                sum_y[x] = static_cast<std::int16_t>(sum_y[x] + (slope_y[x] & on));
            }
        }
    std::int16_t* __restrict mean_x = means.x.view().row(y) + x0, * __restrict mean_y =
                                                                      means.y.view().row(y) + x0;
    for (int x = 0; x < count; ++x)
        mean_x[x] = static_cast<std::int16_t>(step::rounded_slope(sum_x[x], step::share_of(n[x])));
    for (int x = 0; x < count; ++x)
        mean_y[x] = static_cast<std::int16_t>(step::rounded_slope(sum_y[x], step::share_of(n[x])));
}

HEXRELIEF_SMALL_VECTORS void average_row(DisparityView map, const SlopeViews& slopes, int stride_px, int y,
                                         Slopes& means) {
    for (int x = 0; x < map.width; x += kBlock)
        average_block(map, slopes, stride_px, x, y, std::min(kBlock, map.width - x), means);
}

Slopes empty_slopes(const Disparities16& map) {
    return {Raster<std::int16_t>(map.width(), map.height(), 0),
            Raster<std::int16_t>(map.width(), map.height(), 0)};
}

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

Slopes find_slopes(const Disparities16& map, int stride_px, ThreadPool& pool) {
    Slopes fitted = empty_slopes(map), means = empty_slopes(map);
    for_each_row(pool, map.height(), [&](int y) { fit_row(map.view(), y, fitted); });
    const Slopes& lines = fitted;
    const SlopeViews views{lines.x.view(), lines.y.view()};
    for_each_row(pool, map.height(), [&](int y) { average_row(map.view(), views, stride_px, y, means); });
    return means;
}

Disparities16 smoothed(const Disparities16& map, const ColorPlanes& colors, ThreadPool& pool) {
    const Slopes slopes = find_slopes(map, step::kNearSlopes_px, pool);
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
