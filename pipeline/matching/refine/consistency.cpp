#include "pipeline/matching/refine/consistency.h"

#include <vector>

#include "pipeline/base/simd.h"
#include "pipeline/data/union_find.h"
#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/median_step.h"

namespace hexrelief::matching {
namespace {

HEXRELIEF_SMALL_VECTORS void median_row(DisparityView map, int y, std::int16_t* __restrict out) {
    const std::int16_t* __restrict row = map.row(y);
    for (int x = 0; x < map.width; ++x) out[x] = step::median_around(row + x, map.stride);
}

// Removes small patches of neighbours that differ by at most config.speckle_step.
void remove_speckles(const ConsistencyConfig& config, Disparities16& map) {
    const DisparityOut view = map.view();
    const int width = map.width(), height = map.height();
    UnionFind patches(static_cast<std::size_t>(width) * height);
    const auto joined = [&](std::int16_t a, std::int16_t b) {
        return step::joined(a, b, config.speckle_step);
    };
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto pixel = static_cast<std::uint32_t>(y) * width + x;
            if (joined(view.at(x, y), view.at(x + 1, y))) patches.join(pixel, pixel + 1);
            if (joined(view.at(x, y), view.at(x, y + 1))) patches.join(pixel, pixel + width);
        }
    }
    std::vector<int> pixels(static_cast<std::size_t>(width) * height);
    for (std::uint32_t i = 0; i < pixels.size(); ++i) ++pixels[patches.find(i)];
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (pixels[patches.find(static_cast<std::uint32_t>(y) * width + x)] <=
                step::largest_speckle(config, view.at(x, y)))
                view.at(x, y) = kUnknown16;
}

}  // namespace

Disparities16 median_filtered(const Disparities16& map, ThreadPool& pool) {
    Disparities16 result(map.width(), map.height(), kUnknown16);
    for_each_row(pool, map.height(), [&](int y) { median_row(map.view(), y, result.view().row(y)); });
    return result;
}

TrustedMatches find_trusted_matches(const ViewDisparities& unfiltered, const ConsistencyConfig& config,
                                    ThreadPool& pool) {
    const ViewDisparities views{median_filtered(unfiltered.left, pool),
                                median_filtered(unfiltered.right, pool)};
    const int width = views.left.width(), height = views.left.height();
    TrustedMatches result{Disparities16(width, height, kUnknown16), Disparities16(width, height, kUnknown16),
                          Raster<std::int32_t>(width, height, step::kAnything)};
    const DisparityView left = views.left.view(), right = views.right.view();
    const DisparityOut checked = result.left.view();
    for_each_row(pool, height, [&](int y) {
        for (int x = 0; x < width; ++x)
            checked.at(x, y) = step::checked_match(left.at(x, y), right.row(y), x, width, config);
    });
    if (config.speckle_pixels > 0) remove_speckles(config, result.left);
    const DisparityOut trusted = result.right.view();
    for_each_row(pool, height, [&](int y) {
        for (int x = 0; x < width; ++x) {
            const int column = step::matching_left_column(x, config.min_px, right.at(x, y));
            trusted.at(x, y) =
                step::agreed(right.at(x, y), checked.row(y), column, width,
                             config.left_right_limit >= 0 ? config.left_right_limit : kOnePixel);
        }
        for (int x = 0; x < width; ++x)
            result.nearest_seen.view().at(x, y) = step::nearest_seen(trusted.row(y) + x);
    });
    return result;
}

}  // namespace hexrelief::matching
