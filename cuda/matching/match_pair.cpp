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

// The pair at one of its sizes, and what matching finds there.
struct Level {
    DisparityRange range;
    int width, height;
    RasterView<std::int16_t> left, right;  // winners, with a border of kUnknown16
    DeviceColors colors;
    PairPixels pixels;
    PairArrays pair;
};
Level take_level(Arena& arena, int width, int height, const DisparityRange& range, bool in_color) {
    const auto map = [&] { return take_bordered_raster<std::int16_t>(arena, width, height); };
    const auto colors = [&] { return take_plain_raster<std::uint32_t>(arena, width, height); };
    return {range, width, height, map(), map(), {colors(), colors(), in_color}, {}, {}};
}

// Coarse to fine, as match() of pipeline/matching: down to the size at which all of the range is searched,
// and at least to half size, whose matches fill holes.
std::vector<Level> take_levels(Arena& arena, const StereoPair& pair, const DisparityRange& range) {
    const bool in_color = pair.left.channels == pair.right.channels && pair.left.channels > 1;
    std::vector<Level> levels = {take_level(arena, pair.left.width, pair.left.height, range, in_color)};
    while (levels.size() < 2 || !is_searched_wholly(levels.back().range)) {
        const Level& last = levels.back();
        levels.push_back(take_level(arena, step::half_size(last.width), step::half_size(last.height),
                                    at_half_size(last.range), in_color));
    }
    return levels;
}

void upload(Workspace& work, const StereoPair& pair, Level& level) {
    const Image* const images[] = {&pair.left, &pair.right};
    for (int i = 0; i < 2; ++i) {
        std::uint8_t* const pixels = work.arena.take<std::uint8_t>(images[i]->pixels.size());
        work.staging.upload(work.stream, pixels, images[i]->pixels.data(), images[i]->pixels.size());
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

ConsistencyConfig consistency_of(ConsistencyConfig config, const Level& level) {
    config.min_px = level.range.min_px;
    return config;
}

CheckArrays take_check_arrays(Arena& arena, const Level& level, const RasterView<std::int16_t>& checked) {
    const auto map = [&] { return take_bordered_raster<std::int16_t>(arena, level.width, level.height); };
    const std::size_t pixels = static_cast<std::size_t>(level.width) * level.height;
    return {level.left,
            level.right,
            map(),
            map(),
            {arena.take<std::uint32_t>(pixels), arena.take<std::uint32_t>(pixels)},
            checked};
}

void fill_borders_of(cudaStream_t stream, const std::vector<Level>& levels, const CheckArrays& check) {
    std::vector<Border> borders;
    for (const RasterView<std::int16_t>& map : {check.left_medians, check.right_medians, check.checked})
        borders.push_back({map, kUnknownBytes});
    for (const Level& level : levels)
        for (const RasterView<std::int16_t>& map : {level.left, level.right})
            borders.push_back({map, kUnknownBytes});
    fill_borders(stream, borders);
}

// Finds the winners of all levels, and checks those of half size. Small levels leave most of the device idle:
// beside each, the side stream prepares the next one; beside the last one it checks half size.
void match_levels(Workspace& work, const MatchingConfig& config, std::vector<Level>& levels,
                  const CheckArrays& check_half) {
    const cudaStream_t side = work.side.get();
    const auto prepare = [&](Level& level) {
        prepare_pair(side, level.pixels, level.pair);
        work.side.mark();
    };
    work.side.begin_after(work.stream);
    for (std::size_t i = 1; i < levels.size(); ++i)
        halve_pictures(side, work.arena, levels[i - 1], levels[i]);
    prepare(levels.back());
    for (std::size_t i = levels.size(); i-- > 0;) {
        const Level& level = levels[i];
        work.side.let_wait_for_mark(work.stream);
        work.clock.ended("colours, census");
        if (i > 0) prepare(levels[i - 1]);
        match_views(work, level.pair, {level.range, config.penalties},
                    i + 1 < levels.size() ? levels[i + 1].left : RasterView<std::int16_t>{},
                    {level.left, level.right});
        if (i != 1) continue;
        work.side.begin_after(work.stream);
        StageClock not_timed;
        check_views(side, check_half, consistency_of(at_half_size(config.consistency), level), not_timed);
    }
    work.side.mark();
    work.side.let_wait_for_mark(work.stream);
}

}  // namespace

MatchedMap match_pair(Workspace& work, const StereoPair& pair, const MatchingConfig& config) {
    check_limits(pair, config);
    Arena& arena = work.arena;
    arena.reset();
    // what a call that failed may have left
    work.side.mark();
    work.side.let_wait_for_mark(work.stream);
    // Beside the launches and while the device matches.
    std::future<FrameSegments> frame_segments_found = std::async(std::launch::async, [&] {
        return find_frame_segments(pair.left, config.range.min_px + config.range.count);
    });
    const int width = pair.left.width, height = pair.left.height;
    std::vector<Level> levels = take_levels(arena, pair, config.range);
    const Level &full = levels[0], &half = levels[1];
    const DeviceHalfSizeMatches half_size{take_bordered_raster<std::int16_t>(arena, half.width, half.height),
                                          half.range.min_px};
    const Arena::Mark levels_taken = arena.mark();
    for (Level& level : levels) level.pair = take_pair_arrays(arena, level.colors);
    const CheckArrays check_half = take_check_arrays(arena, half, half_size.left);
    upload(work, pair, levels[0]);
    work.clock.begin(work.stream);
    fill_borders_of(work.stream, levels, check_half);
    match_levels(work, config, levels, check_half);
    arena.release(levels_taken);

    const RefineArrays refined = take_refine_arrays(work.stream, arena, full.left, full.right);
    const ConsistencyConfig consistency = consistency_of(config.consistency, full);
    refine(work, refined, {frame_segments_found, full.colors, half_size, consistency});
    work.clock.end();

    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    MatchedMap map{width, height, {}, {}};
    map.disparities.resize(pixels);
    map.is_matched.resize(pixels);
    work.staging.download_all(work.stream,
                              {{map.disparities.data(), refined.result.origin, pixels * sizeof(std::int16_t)},
                               {map.is_matched.data(), refined.trusted.matched.origin, pixels}});
    return map;
}

}  // namespace hexrelief::cuda
