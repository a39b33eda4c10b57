#include "pipeline/matching/refine/slopes.h"

#include <algorithm>

#include "mesher/common/simd.h"
#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/refine/slope_step.h"

namespace hexrelief::matching {
namespace {

struct LineSumsBlock {
    std::int16_t sides[2][kBlock] = {}, v[kBlock] = {}, tv[kBlock] = {}, on[kBlock];
};

// Fits lines at pixels[0 .. count - 1], along x (along = 1) or y (along = stride).
HEXRELIEF_INLINED void fit_lines(const std::int16_t* pixels, std::ptrdiff_t along, int count,
                                 std::int16_t* __restrict slopes) {
    LineSumsBlock s;
    for (int side = 0; side < 2; ++side) {
        const int way = side == 0 ? -1 : 1;
        std::int16_t* const samples = s.sides[side];
        for (int x = 0; x < count; ++x) s.on[x] = step::mask_of(pixels[x] >= 0);
        for (int k = 1; k <= step::kSamples; ++k) {
            const auto t = static_cast<std::int16_t>(way * k);
            const std::int16_t *here = pixels + t * along, *before = here - way * along;
            for (int x = 0; x < count; ++x) {
                s.on[x] = step::run_reaches(s.on[x], here[x], before[x]);
                step::add_sample(samples[x], s.v[x], s.tv[x], t,
                                 static_cast<std::int16_t>(here[x] - pixels[x]), s.on[x]);
            }
        }
    }
    for (int x = 0; x < count; ++x)
        slopes[x] = step::slope_of<std::int16_t>({s.sides[0][x], s.sides[1][x], s.v[x], s.tv[x]});
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

HEXRELIEF_INLINED void average_block(DisparityView map, const SlopeViews& slopes, int x0, int y, int count,
                                     Slopes& means) {
    std::int16_t n[kBlock] = {}, sum_x[kBlock] = {}, sum_y[kBlock] = {};
    const std::int16_t* own = map.row(y) + x0;
    for (int j = -step::kSlopeRadius; j <= step::kSlopeRadius; ++j)
        for (int i = -step::kSlopeRadius; i <= step::kSlopeRadius; ++i) {
            if (!step::is_dark(i, j)) continue;
            const std::int16_t* other = map.row(y + j) + x0 + i;
            const std::int16_t *slope_x = slopes.x.row(y + j) + x0 + i,
                               *slope_y = slopes.y.row(y + j) + x0 + i;
            for (int x = 0; x < count; ++x) {
                const std::int16_t on = step::on_same_surface(other[x], own[x]);
                n[x] = static_cast<std::int16_t>(n[x] - on);
                sum_x[x] = static_cast<std::int16_t>(sum_x[x] + (slope_x[x] & on));
                sum_y[x] = static_cast<std::int16_t>(sum_y[x] + (slope_y[x] & on));
            }
        }
    std::int16_t* __restrict mean_x = means.x.view().row(y) + x0, * __restrict mean_y =
                                                                      means.y.view().row(y) + x0;
    for (int x = 0; x < count; ++x) mean_x[x] = step::mean_slope(sum_x[x], n[x]);
    for (int x = 0; x < count; ++x) mean_y[x] = step::mean_slope(sum_y[x], n[x]);
}

HEXRELIEF_SMALL_VECTORS void average_row(DisparityView map, const SlopeViews& slopes, int y, Slopes& means) {
    for (int x = 0; x < map.width; x += kBlock)
        average_block(map, slopes, x, y, std::min(kBlock, map.width - x), means);
}

Slopes empty_slopes(const Disparities16& map) {
    return {Raster<std::int16_t>(map.width(), map.height(), 0),
            Raster<std::int16_t>(map.width(), map.height(), 0)};
}

}  // namespace

Slopes find_slopes(const Disparities16& map, ThreadPool& pool) {
    Slopes fitted = empty_slopes(map), means = empty_slopes(map);
    for_each_row(pool, map.height(), [&](int y) { fit_row(map.view(), y, fitted); });
    const Slopes& lines = fitted;
    const SlopeViews views{lines.x.view(), lines.y.view()};
    for_each_row(pool, map.height(), [&](int y) { average_row(map.view(), views, y, means); });
    return means;
}

}  // namespace hexrelief::matching
