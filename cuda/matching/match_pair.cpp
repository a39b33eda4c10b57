#include "cuda/matching/match_pair.h"

#include <algorithm>
#include <future>
#include <string>
#include <vector>

#include "cuda/matching/refine/refine.h"
#include "cuda/matching/sgm/match_views.h"
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

// A pair on the device, its pixels as they are on the host, and what matching finds at this size.
struct Level {
    DisparityRange range;
    int width, height;
    PairPixels pixels;
    RasterView<std::int16_t> left, right;
    DeviceColors colors;
};
constexpr int kUnknownBytes = 0xff;
Level take_level(cudaStream_t stream, Arena& arena, int width, int height, const DisparityRange& range,
                 bool in_color) {
    const auto map = [&] { return take_raster<std::int16_t>(stream, arena, width, height, kUnknownBytes); };
    const auto colors = [&] { return take_plain_raster<std::uint32_t>(arena, width, height); };
    return {range, width, height, {}, map(), map(), {colors(), colors(), in_color}};
}

// Coarse to fine, as match() of pipeline/matching: down to the size at which all of the range is searched,
// and at least to half size, whose matches fill holes.
std::vector<Level> take_levels(cudaStream_t stream, Arena& arena, const StereoPair& pair,
                               const DisparityRange& range) {
    const bool in_color = pair.left.channels == pair.right.channels && pair.left.channels > 1;
    std::vector<Level> levels = {
        take_level(stream, arena, pair.left.width, pair.left.height, range, in_color)};
    while (levels.size() < 2 || !is_searched_wholly(levels.back().range)) {
        const Level& last = levels.back();
        levels.push_back(take_level(stream, arena, step::half_size(last.width), step::half_size(last.height),
                                    at_half_size(last.range), in_color));
    }
    return levels;
}

void upload(cudaStream_t stream, Arena& arena, Staging& staging, const StereoPair& pair, Level& level) {
    const Image* const images[] = {&pair.left, &pair.right};
    for (int i = 0; i < 2; ++i) {
        std::uint8_t* const pixels = arena.take<std::uint8_t>(images[i]->pixels.size());
        staging.upload(stream, pixels, images[i]->pixels.data(), images[i]->pixels.size());
        level.pixels.pixels[i] = pixels;
        level.pixels.channels[i] = images[i]->channels;
    }
}

void halve_pictures(cudaStream_t stream, Arena& arena, const Level& level, Level& half) {
    std::uint8_t* pixels[2];
    for (int i = 0; i < 2; ++i) {
        const int channels = level.pixels.channels[i];
        pixels[i] = arena.take<std::uint8_t>(static_cast<std::size_t>(half.width) * half.height * channels);
        half.pixels.pixels[i] = pixels[i];
        half.pixels.channels[i] = channels;
    }
    halve(stream, level.pixels, level.width, level.height, pixels);
}

// Finds the views' winners. half: those of the left view at half size.
void match_level(cudaStream_t stream, Arena& arena, StageClock& clock, const Level& level,
                 const step::PathPenalties& penalties, const RasterView<std::int16_t>& half) {
    const Arena::Mark before = arena.mark();
    PairArrays pair = take_pair_arrays(stream, arena, level.colors, level.colors.in_color ? 3 : 1);
    prepare_pair(stream, level.pixels, pair);
    clock.ended("colours, census");
    match_views(stream, arena, pair, {level.range, penalties}, half, {level.left, level.right}, clock);
    arena.release(before);
}

ConsistencyConfig consistency_of(const MatchingConfig& config, const Level& level) {
    ConsistencyConfig consistency = config.consistency;
    consistency.min_px = level.range.min_px;
    return consistency;
}

DeviceHalfSizeMatches check_half_size(cudaStream_t stream, Arena& arena, StageClock& clock,
                                      const Level& level, const MatchingConfig& config) {
    const auto map = [&] {
        return take_raster<std::int16_t>(stream, arena, level.width, level.height, kUnknownBytes);
    };
    const RasterView<std::int16_t> checked = map();
    const Arena::Mark result = arena.mark();
    const std::size_t pixels = static_cast<std::size_t>(level.width) * level.height;
    const SpeckleArrays speckles{arena.take<std::uint32_t>(pixels), arena.take<std::uint32_t>(pixels)};
    check_views(stream, {level.left, level.right, map(), map(), speckles, checked},
                consistency_of(config, level), clock);
    arena.release(result);
    return {checked, level.range.min_px};
}

}  // namespace

MatchedMap match_pair(cudaStream_t stream, Arena& arena, Staging& staging, StageClock& clock,
                      const StereoPair& pair, const MatchingConfig& config) {
    check_limits(pair, config);
    arena.reset();
    // Beside the launches and while the device matches.
    std::future<FrameSegments> frame_segments_found = std::async(std::launch::async, [&] {
        return find_frame_segments(pair.left, config.range.min_px + config.range.count);
    });
    const int width = pair.left.width, height = pair.left.height;
    std::vector<Level> levels = take_levels(stream, arena, pair, config.range);
    const Level &full = levels[0], &half = levels[1];
    const Arena::Mark levels_taken = arena.mark();
    upload(stream, arena, staging, pair, levels[0]);
    clock.begin(stream);
    for (std::size_t i = 1; i < levels.size(); ++i) halve_pictures(stream, arena, levels[i - 1], levels[i]);
    for (std::size_t i = levels.size(); i-- > 0;)
        match_level(stream, arena, clock, levels[i], config.penalties,
                    i + 1 < levels.size() ? levels[i + 1].left : RasterView<std::int16_t>{});
    arena.release(levels_taken);
    const DeviceHalfSizeMatches half_size = check_half_size(stream, arena, clock, half, config);

    const RefineArrays refined = take_refine_arrays(stream, arena, full.left, full.right);
    const ConsistencyConfig consistency = consistency_of(config, full);
    const FrameSegments frame_segments = frame_segments_found.get();
    refine(stream, staging, refined, {frame_segments, full.colors, half_size, consistency}, clock);

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
