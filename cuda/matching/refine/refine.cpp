#include "cuda/matching/refine/refine.h"

#include <utility>

#include "cuda/matching/common/borders.h"
#include "cuda/matching/refine/sides.h"
#include "cuda/matching/refine/smooth.h"
#include "pipeline/matching/refine/side_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kLists = 1 + step::kVoteRounds;

// Clears the arrays that the steps after the views' comparison use.
void prepare(cudaStream_t stream, const RefineArrays& arrays) {
    const auto set = [&](void* data, int byte, std::size_t bytes) {
        check(cudaMemsetAsync(data, byte, bytes, stream), "clearing");
    };
    const int width = arrays.left.width, height = arrays.left.height;
    fill_borders(stream, {{arrays.a, kUnknownBytes},
                          {arrays.b, kUnknownBytes},
                          {arrays.trusted.right, kUnknownBytes},
                          {arrays.records, kUnknownBytes},
                          {arrays.planes[1], kUnknownBytes},
                          {arrays.slopes.fitted, 0}});
    set(arrays.trusted.holes.count, 0, kLists * sizeof(std::uint32_t));
    set(arrays.frame.least, kUnknownBytes, matching::cell_grid(width, height).size() * sizeof(std::int16_t));
}

}  // namespace

RefineArrays take_refine_arrays(Arena& arena, const matching::RasterView<std::int16_t>& left,
                                const matching::RasterView<std::int16_t>& right, const FrameArrays& frame) {
    const int width = left.width, height = left.height;
    const auto map = [&] { return take_bordered_raster<std::int16_t>(arena, width, height); };
    const std::size_t pixels = static_cast<std::size_t>(width) * height;
    RefineArrays arrays{};
    arrays.left = left;
    arrays.right = right;
    arrays.a = map();
    arrays.b = map();
    arrays.slopes = {take_bordered_raster<FittedPixel>(arena, width, height),
                     take_plain_raster<std::uint32_t>(arena, (width + 31) / 32, height)};
    arrays.planes[0] = take_bordered_raster<PlaneRecord>(arena, width, height);
    arrays.planes[1] = take_bordered_raster<PlaneRecord>(arena, width, height);
    static_assert(sizeof(PixelRecord) == sizeof(PlaneRecord));
    arrays.records = {reinterpret_cast<PixelRecord*>(arrays.planes[0].origin), width, height,
                      arrays.planes[0].stride};
    arrays.speckles = {arena.take<std::uint32_t>(pixels), arena.take<std::uint32_t>(pixels)};
    std::uint32_t* const counts = arena.take<std::uint32_t>(kLists);
    arrays.trusted = {map(),
                      take_plain_raster<std::int32_t>(arena, width, height),
                      take_plain_raster<std::uint8_t>(arena, width, height),
                      {arrays.speckles.sizes, counts}};
    for (int round = 0; round < step::kVoteRounds; ++round)
        arrays.votes[round] =
            take_vote_arrays(arena, width, height, {arrays.speckles.parents, counts + 1 + round});
    arrays.known = take_known_pixels(arena, width, height);
    arrays.frame = frame;
    arrays.sides = take_block_sides(arena, width, height);
    arrays.voter_weights = take_plain_raster<std::uint8_t>(arena, width, height);
    arrays.result = take_plain_raster<std::int16_t>(arena, width, height);
    return arrays;
}

void check_views(cudaStream_t stream, const CheckArrays& arrays, const matching::ConsistencyConfig& config) {
    filter_medians(stream, {reading(arrays.left), arrays.left_medians},
                   {reading(arrays.right), arrays.right_medians});
    check_left(stream, reading(arrays.left_medians), reading(arrays.right_medians), config, arrays.checked);
    if (config.speckle_pixels > 0) remove_speckles(stream, config, arrays.speckles, arrays.checked);
}

void fill(Workspace& work, const RefineArrays& arrays, const RefineInput& input) {
    const cudaStream_t stream = work.stream;
    const matching::ConsistencyConfig& config = input.config;
    const PackedColors left = reading(input.colors.left);
    const matching::RasterView<std::int16_t>& checked = arrays.left;
    work.side.begin_after(stream);
    prepare(work.side.get(), arrays);
    work.side.mark();
    check_views(stream, {arrays.left, arrays.right, arrays.a, arrays.b, arrays.speckles, checked}, config);
    work.side.let_wait_for_mark(stream);
    find_trusted(stream, reading(checked), reading(arrays.b), config, arrays.trusted);
    add_half_size_matches(stream, reading(input.half_size.left), input.half_size.min_px,
                          reading(arrays.trusted.right), config.min_px, checked);
    work.side.begin_after(stream);
    find_known(work.side.get(), reading(checked), arrays.known);
    work.side.mark();
    find_slopes(stream, {reading(checked), left, {}, {}, RecordsOf::beside_unknown, step::kFarSlopes_px, {}},
                {arrays.slopes.fitted, {}}, arrays.records);
    work.side.let_wait_for_mark(stream);
    fill_unknown(stream,
                 {arrays.trusted.holes, reading(arrays.trusted.right), reading(arrays.records),
                  reading(arrays.trusted.nearest_seen), left, reading(input.colors.right), config.min_px},
                 arrays.known, arrays.left);
}

void raise_frame_segments(Workspace& work, const matching::FrameSegments& segments,
                          const RefineArrays& arrays) {
    raise_frame_segments(work, segments, arrays.frame, reading(arrays.known.rows), arrays.left);
}

void smooth(Workspace& work, const RefineArrays& arrays, const RefineInput& input) {
    const cudaStream_t stream = work.stream;
    const DeviceColors& colors = input.colors;
    const matching::ConsistencyConfig& config = input.config;
    const PackedColors left = reading(colors.left);
    const PixelRecords records = reading(arrays.records);
    const matching::RasterView<const std::int32_t> nearest_seen = reading(arrays.trusted.nearest_seen);
    const matching::RasterView<const std::uint8_t> matched = reading(arrays.trusted.matched);
    const matching::RasterView<const std::uint32_t> discontinuous = reading(arrays.slopes.discontinuous);

    VoterInput voters{reading(arrays.left),  nearest_seen,  left,
                      reading(colors.right), config.min_px, colors.in_color};
    weigh_voters(stream, voters, matched, arrays.sides, arrays.trusted.holes, arrays.voter_weights);
    const matching::RasterView<const std::uint8_t> weights = reading(arrays.voter_weights);
    find_slopes(
        stream,
        {reading(arrays.left), left, weights, input.hole_colors, RecordsOf::all, step::kFarSlopes_px, {}},
        arrays.slopes, arrays.records);
    take_votes(stream,
               {reading(arrays.left), records, discontinuous, nearest_seen, weights, arrays.trusted.holes,
                config.min_px},
               arrays.votes[0], arrays.a);
    matching::RasterView<std::int16_t> map = arrays.a, changed = arrays.b;
    for (int round = 1; round < step::kVoteRounds; ++round) {
        find_slopes(stream,
                    {reading(map),
                     left,
                     {},
                     {},
                     RecordsOf::all,
                     step::kNearSlopes_px,
                     reading(arrays.votes[round - 1].changed_blocks)},
                    arrays.slopes, arrays.records);
        voters.map = reading(map);
        weigh_later_voters(stream, voters, arrays.sides, arrays.records);
        take_votes(stream, {reading(map), records, discontinuous, nearest_seen, {}, {}, config.min_px},
                   arrays.votes[round], changed);
        std::swap(map, changed);
    }
    for (int round = 0; round < step::kSideRounds; ++round) {
        choose_sides(stream, {reading(map), left, reading(colors.right), nearest_seen, config.min_px},
                     changed);
        std::swap(map, changed);
    }

    filter_median(stream, {reading(map), changed});
    find_slopes(stream, {reading(changed), left, {}, {}, RecordsOf::all, step::kNearSlopes_px, {}},
                {arrays.slopes.fitted, {}}, arrays.planes[0]);
    smooth(stream, arrays.planes[0], arrays.planes[1], arrays.result);
}

}  // namespace hexrelief::cuda
