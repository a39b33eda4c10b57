#include "pipeline/matching/refine/consistency.h"

#include <cstddef>
#include <utility>

#include "pipeline/base/simd.h"
#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/median_step.h"

namespace hexrelief::matching {
namespace {

HEXRELIEF_SMALL_VECTORS void median_row(DisparityView map, int y, std::int16_t* __restrict out) {
    const std::int16_t* __restrict row = map.row(y);
    for (int x = 0; x < map.width; ++x) out[x] = step::median_around(row + x, map.stride);
}

void remove_speckles(const ConsistencyConfig& config, Disparities16& map, ThreadPool& pool) {
    const std::size_t pixels = static_cast<std::size_t>(map.width()) * map.height();
    RawVector<unsigned> parents(pixels), sizes(pixels);
    const DisparityOut out = map.view();
    const step::Patches patches{std::as_const(map).view(), config, parents.data(), sizes.data()};
    const auto for_each_pixel = [&](const auto& visit) {
        for_each_row(pool, map.height(), [&](int y) {
            for (int x = 0; x < map.width(); ++x) visit(x, y);
        });
    };
    for_each_pixel([&](int x, int y) { patches.begin(x, y); });
    for_each_pixel([&](int x, int y) { patches.join(x, y); });
    for_each_pixel([&](int x, int y) { patches.count(x, y); });
    for_each_pixel([&](int x, int y) {
        if (patches.is_speckle(x, y)) out.at(x, y) = kUnknown16;
    });
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
    if (config.speckle_pixels > 0) remove_speckles(config, result.left, pool);
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
