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

// The pair as it is on the host, on the device.
struct DevicePictures {
    const std::uint8_t* pixels[2];
    int channels[2];
    Arena::Mark before;  // what was taken
};

// Where the picture is one band, the pictures and what costs alone need lie where the sums will, as both are
// never needed at a time.
DevicePictures upload(cudaStream_t stream, Arena& arena, Staging& staging, const StereoPair& pair,
                      MatchingArrays& matching) {
    DevicePictures pictures{{}, {pair.left.channels, pair.right.channels}, arena.mark()};
    if (matching.one_band()) {
        take_sums(arena, matching);
        arena.release(pictures.before);
    }
    const Image* const images[] = {&pair.left, &pair.right};
    for (int i = 0; i < 2; ++i) {
        std::uint8_t* const pixels = arena.take<std::uint8_t>(images[i]->pixels.size());
        staging.upload(stream, pixels, images[i]->pixels.data(), images[i]->pixels.size());
        pictures.pixels[i] = pixels;
    }
    return pictures;
}

// Leaves the sums taken and, where the picture is one band, its costs found.
void prepare_matching(cudaStream_t stream, Arena& arena, StageClock& clock, const DevicePictures& pictures,
                      const step::PathPenalties& penalties, MatchingArrays& matching) {
    take_cost_arrays(stream, arena, matching.pair);
    prepare_pair(stream, pictures.pixels, pictures.channels, penalties, matching.pair);
    clock.ended("colours, census");
    if (matching.one_band()) {
        find_costs(stream, matching.pair, matching.min_px, matching.volume);
        clock.ended("costs");
        arena.release(pictures.before);
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
        take_matching_arrays(stream, arena, colors, as_grey ? 1 : 3, config.range, config.penalties.p1);
    const DevicePictures pictures = upload(stream, arena, staging, pair, matching);
    clock.begin(stream);
    prepare_matching(stream, arena, clock, pictures, config.penalties, matching);
    match_views(stream, matching, left, right, clock);

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
