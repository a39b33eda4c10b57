#include "cuda/matching/refine/refine.h"

#include <utility>

#include "cuda/matching/refine/smooth.h"
#include "pipeline/matching/refine/smooth_step.h"

namespace hexrelief::cuda {

RefineArrays take_refine_arrays(cudaStream_t stream, Arena& arena, int width, int height) {
    constexpr int kUnknownBytes = 0xff;
    const auto map = [&] { return take_raster<std::int16_t>(stream, arena, width, height, kUnknownBytes); };
    const auto slopes = [&] { return take_raster<std::int16_t>(stream, arena, width, height, 0); };
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    RefineArrays arrays{};
    arrays.left = map();
    arrays.right = map();
    arrays.a = map();
    arrays.b = map();
    arrays.fitted = {slopes(), slopes()};
    arrays.slopes = {slopes(), slopes()};
    arrays.trusted = {map(), take_plain_raster<std::int32_t>(arena, width, height),
                      take_plain_raster<std::uint8_t>(arena, width, height)};
    arrays.speckles = {arena.take<std::uint32_t>(pixels), arena.take<std::uint32_t>(pixels)};
    for (std::uint16_t*& distances : arrays.fill.distances) distances = arena.take<std::uint16_t>(pixels);
    arrays.votes = {take_raster<std::uint8_t>(stream, arena, width, height, 0), arrays.speckles.labels,
                    arena.take<std::uint32_t>(1)};
    arrays.result = take_plain_raster<std::int16_t>(arena, width, height);
    return arrays;
}

void refine(cudaStream_t stream, const RefineArrays& arrays, const PackedColors& colors,
            const ConsistencyConfig& config, StageClock& clock) {
    const SlopeRasters &fitted = arrays.fitted, &slopes = arrays.slopes;
    const DisparityView slope_x = reading(slopes.x), slope_y = reading(slopes.y);

    filter_median(stream, reading(arrays.left), arrays.a);
    filter_median(stream, reading(arrays.right), arrays.b);
    const RasterView<std::int16_t>& checked = arrays.left;
    check_left(stream, reading(arrays.a), reading(arrays.b), config, checked);
    clock.ended("medians, check");
    if (config.speckle_pixels > 0) remove_speckles(stream, config, arrays.speckles, checked);
    clock.ended("speckles");
    find_trusted(stream, reading(checked), reading(arrays.b), config, arrays.trusted);
    find_slopes(stream, reading(checked), kVoteSlopes, fitted, slopes);
    clock.ended("trusted, slopes");
    const RasterView<const std::int32_t> nearest_seen = reading(arrays.trusted.nearest_seen);
    fill_unknown(
        stream,
        {reading(checked), reading(arrays.trusted.right), slope_x, slope_y, nearest_seen, config.min_px},
        arrays.fill, arrays.a);
    clock.ended("fill");

    find_slopes(stream, reading(arrays.a), kVoteSlopes, fitted, slopes);
    take_votes(stream,
               {reading(arrays.a), slope_x, slope_y, colors, nearest_seen, reading(arrays.trusted.matched),
                config.min_px},
               arrays.votes, arrays.b);
    clock.ended("votes, first round");
    find_slopes(stream, reading(arrays.b), kVoteSlopes, fitted, slopes);
    take_votes(stream, {reading(arrays.b), slope_x, slope_y, colors, nearest_seen, {}, config.min_px},
               arrays.votes, arrays.a);
    clock.ended("votes, second round");

    filter_median(stream, reading(arrays.a), arrays.b);
    find_slopes(stream, reading(arrays.b), kSmoothingSlopes, fitted, slopes);
    RasterView<std::int16_t> from = arrays.b, to = arrays.a;
    for (int level = 0; level < step::kSmoothLevels; ++level) {
        const bool last = level + 1 == step::kSmoothLevels;
        smooth(stream, {reading(from), slope_x, slope_y, colors}, 1 << level, last ? arrays.result : to);
        std::swap(from, to);
    }
    clock.ended("smoothing");
}

}  // namespace hexrelief::cuda
