#include "cuda/matching/match_pair.h"

#include <algorithm>
#include <string>

#include "cuda/matching/refine/refine.h"
#include "cuda/matching/sgm/match_views.h"
#include "cuda/matching/sgm/paths.h"
#include "pipeline/matching/common/half_size_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kLongestSide_px = 32767;

void check_limits(const StereoPair& pair, const MatchingConfig& config) {
    if (config.range.count > kMostDisparities)
        throw Error(ErrorKind::device, "backend cuda: " + std::to_string(config.range.count) +
                                           " disparities; at most " + std::to_string(kMostDisparities) +
                                           " can be searched; use --backend cpu");
    if (std::max(pair.left.width, pair.left.height) > kLongestSide_px)
        throw Error(ErrorKind::device,
                    "backend cuda: the pictures' sides may have 32767 px; use --backend cpu");
}

// A pair on the device, its pixels as they are on the host.
struct DevicePictures {
    const std::uint8_t* pixels[2];
    int channels[2];
    int width, height;
};

// What matching finds, and the colours, which refinement reads as well.
struct DeviceViews {
    RasterView<std::int16_t> left, right;
    DeviceColors colors;
};
constexpr int kUnknownBytes = 0xff;
DeviceViews take_views(cudaStream_t stream, Arena& arena, int width, int height, bool in_color) {
    return {take_raster<std::int16_t>(stream, arena, width, height, kUnknownBytes),
            take_raster<std::int16_t>(stream, arena, width, height, kUnknownBytes),
            {take_plain_raster<std::uint32_t>(arena, width, height),
             take_plain_raster<std::uint32_t>(arena, width, height), in_color}};
}

MatchingArrays take_matching(cudaStream_t stream, Arena& arena, const DeviceViews& views,
                             const MatchingConfig& config) {
    return take_matching_arrays(stream, arena, views.colors, views.colors.in_color ? 3 : 1, config.range,
                                config.penalties.p1);
}

// Where the picture is one band, the pictures and what costs alone need lie where the sums will, as both are
// never needed at a time.
DevicePictures upload(cudaStream_t stream, Arena& arena, Staging& staging, const StereoPair& pair,
                      MatchingArrays& matching) {
    DevicePictures pictures{{}, {pair.left.channels, pair.right.channels}, pair.left.width, pair.left.height};
    if (matching.one_band()) {
        const Arena::Mark before = arena.mark();
        take_sums(arena, matching);
        arena.release(before);
    }
    const Image* const images[] = {&pair.left, &pair.right};
    for (int i = 0; i < 2; ++i) {
        std::uint8_t* const pixels = arena.take<std::uint8_t>(images[i]->pixels.size());
        staging.upload(stream, pixels, images[i]->pixels.data(), images[i]->pixels.size());
        pictures.pixels[i] = pixels;
    }
    return pictures;
}

// Finds the views' winners. before: what was taken when the pictures were not yet, if their memory may be
// used.
void find_views(cudaStream_t stream, Arena& arena, StageClock& clock, const DevicePictures& pictures,
                const Arena::Mark& before, const step::PathPenalties& penalties, MatchingArrays& matching,
                const DeviceViews& views) {
    take_cost_arrays(stream, arena, matching.pair);
    prepare_pair(stream, pictures.pixels, pictures.channels, penalties, matching.pair);
    clock.ended("colours, census");
    if (matching.one_band()) {
        find_costs(stream, matching.pair, matching.min_px, matching.volume);
        clock.ended("costs");
        arena.release(before);
    }
    take_sums(arena, matching);
    match_views(stream, matching, views.left, views.right, clock);
}

// pixels: where the pictures go.
DevicePictures halve_pictures(cudaStream_t stream, const DevicePictures& pictures,
                              std::uint8_t* const pixels[2]) {
    DevicePictures half = pictures;
    half.width = step::half_size(pictures.width);
    half.height = step::half_size(pictures.height);
    for (int i = 0; i < 2; ++i) {
        halve(stream, pictures.pixels[i], pictures.width, pictures.height, pictures.channels[i], pixels[i]);
        half.pixels[i] = pixels[i];
    }
    return half;
}

DeviceHalfSizeMatches match_at_half_size(cudaStream_t stream, Arena& arena, StageClock& clock,
                                         const DevicePictures& pictures, bool in_color,
                                         MatchingConfig config) {
    config.range = at_half_size(config.range);
    config.consistency.min_px = config.range.min_px;
    const int width = pictures.width, height = pictures.height;
    const auto map = [&] { return take_raster<std::int16_t>(stream, arena, width, height, kUnknownBytes); };
    const RasterView<std::int16_t> checked = map();
    const Arena::Mark result = arena.mark();
    const DeviceViews views = take_views(stream, arena, width, height, in_color);
    const Arena::Mark results = arena.mark();
    MatchingArrays matching = take_matching(stream, arena, views, config);
    find_views(stream, arena, clock, pictures, arena.mark(), config.penalties, matching, views);
    arena.release(results);
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    const SpeckleArrays speckles{arena.take<std::uint32_t>(pixels), arena.take<std::uint32_t>(pixels)};
    check_views(stream, {views.left, views.right, map(), map(), speckles, checked}, config.consistency,
                clock);
    arena.release(result);
    return {checked, config.range.min_px};
}

}  // namespace

MatchedMap match_pair(cudaStream_t stream, Arena& arena, Staging& staging, StageClock& clock,
                      const StereoPair& pair, const MatchingConfig& config) {
    check_limits(pair, config);
    arena.reset();
    const int width = pair.left.width, height = pair.left.height;
    const bool in_color = pair.left.channels == pair.right.channels && pair.left.channels > 1;
    const DeviceViews views = take_views(stream, arena, width, height, in_color);
    const std::size_t half_pixels =
        static_cast<std::size_t>(step::half_size(width)) * step::half_size(height);
    std::uint8_t* const halves[2] = {arena.take<std::uint8_t>(half_pixels * pair.left.channels),
                                     arena.take<std::uint8_t>(half_pixels * pair.right.channels)};
    const Arena::Mark views_and_halves = arena.mark();

    MatchingArrays matching = take_matching(stream, arena, views, config);
    const Arena::Mark before_pictures = arena.mark();
    const DevicePictures pictures = upload(stream, arena, staging, pair, matching);
    clock.begin(stream);
    const DevicePictures half = halve_pictures(stream, pictures, halves);
    find_views(stream, arena, clock, pictures, before_pictures, config.penalties, matching, views);
    arena.release(views_and_halves);
    const DeviceHalfSizeMatches half_size = match_at_half_size(stream, arena, clock, half, in_color, config);

    const RefineArrays refined = take_refine_arrays(stream, arena, views.left, views.right);
    ConsistencyConfig consistency = config.consistency;
    consistency.min_px = config.range.min_px;
    // While the device matches.
    const FrameEdges edges = find_frame_edges(pair.left, config.range.min_px + config.range.count);
    refine(stream, staging, refined, {edges, views.colors, half_size, consistency}, clock);

    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    MatchedMap map{width, height, {}, {}};
    map.disparities.resize(pixels);
    map.is_matched.resize(pixels);
    staging.download_all(stream,
                         {{map.disparities.data(), refined.result.origin, pixels * sizeof(std::int16_t)},
                          {map.is_matched.data(), refined.trusted.matched.origin, pixels}});
    return map;
}

}  // namespace hexrelief::cuda
