#include "cuda/matching/match_pair.h"

#include <algorithm>
#include <string>

#include "cuda/matching/refine/refine.h"
#include "cuda/matching/sgm/match_views.h"
#include "cuda/matching/sgm/paths.h"

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

// Leaves the sums taken and, where the picture is one band, its costs found: then what costs alone need lies
// where the sums will, so that both never take memory at a time.
void prepare_matching(cudaStream_t stream, Arena& arena, Staging& staging, StageClock& clock,
                      const StereoPair& pair, const MatchingConfig& config, MatchingArrays& matching) {
    const Arena::Mark before = arena.mark();
    if (matching.one_band()) {
        take_sums(arena, matching);
        arena.release(before);
    }
    std::uint8_t* raw[2];
    const Image* const images[] = {&pair.left, &pair.right};
    const int image_channels[] = {pair.left.channels, pair.right.channels};
    for (int i = 0; i < 2; ++i) {
        raw[i] = arena.take<std::uint8_t>(images[i]->pixels.size());
        staging.upload(stream, raw[i], images[i]->pixels.data(), images[i]->pixels.size());
    }
    clock.begin(stream);
    take_cost_arrays(stream, arena, matching.pair);
    prepare_pair(stream, raw, image_channels, config.penalties, matching.pair);
    clock.ended("colours, census");
    if (matching.one_band()) {
        find_costs(stream, matching.pair, config.range.min_px, matching.volume);
        clock.ended("costs");
        arena.release(before);
    }
    take_sums(arena, matching);
}

}  // namespace

MatchedMap match_pair(cudaStream_t stream, Arena& arena, Staging& staging, StageClock& clock,
                      const StereoPair& pair, const MatchingConfig& config) {
    check_limits(pair, config);
    arena.reset();
    const int width = pair.left.width, height = pair.left.height;
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    constexpr int kUnknownBytes = 0xff;
    const auto left = take_raster<std::int16_t>(stream, arena, width, height, kUnknownBytes),
               right = take_raster<std::int16_t>(stream, arena, width, height, kUnknownBytes);
    const auto colors = take_plain_raster<std::uint32_t>(arena, width, height);
    const Arena::Mark views_and_colors = arena.mark();

    const bool as_grey = pair.left.channels != pair.right.channels || pair.left.channels == 1;
    MatchingArrays matching =
        take_matching_arrays(stream, arena, colors, as_grey ? 1 : 3, config.range.count);
    prepare_matching(stream, arena, staging, clock, pair, config, matching);
    match_views(stream, matching, config.range.min_px, config.penalties.p1, left, right, clock);

    arena.release(views_and_colors);
    const RefineArrays refined = take_refine_arrays(stream, arena, left, right);
    ConsistencyConfig consistency = config.consistency;
    consistency.min_px = config.range.min_px;
    refine(stream, refined, reading(colors), consistency, clock);

    MatchedMap map{width, height, {}, {}};
    map.disparities.resize(pixels);
    map.is_matched.resize(pixels);
    staging.download_all(stream,
                         {{map.disparities.data(), refined.result.origin, pixels * sizeof(std::int16_t)},
                          {map.is_matched.data(), refined.trusted.matched.origin, pixels}});
    return map;
}

}  // namespace hexrelief::cuda
