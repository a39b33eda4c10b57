#include "pipeline/matching/refine/refine.h"

#include <utility>
#include <vector>

#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/refine/frame_segment_step.h"
#include "pipeline/matching/refine/side_step.h"
#include "pipeline/matching/refine/slope_step.h"
#include "pipeline/matching/refine/slopes.h"
#include "pipeline/matching/refine/vote_step.h"
#include "pipeline/matching/refine/votes.h"

namespace hexrelief::matching {
namespace {

void raise_frame_segments(const FrameSegments& segments, const DisparityView& matches,
                          const DisparityOut& filled) {
    const CellGrid& grid = segments.grid;
    std::vector<std::int16_t> samples;
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column) {
            const int x = step::middle_of_cell(column, grid.cell_px);
            const int y = step::middle_of_cell(row, grid.cell_px);
            samples.push_back(step::unmatched(matches.at(x, y), filled.at(x, y)));
        }
    const std::vector<std::int16_t> least = least_disparities(segments, samples);
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
        if (least[cell] == kUnknown16) continue;
        const int first_x = static_cast<int>(cell) % grid.columns * grid.cell_px;
        const int first_y = static_cast<int>(cell) / grid.columns * grid.cell_px;
        for (int y = first_y; y < first_y + grid.cell_px; ++y)
            for (int x = first_x; x < first_x + grid.cell_px; ++x)
                filled.at(x, y) = step::raised(matches.at(x, y), filled.at(x, y), least[cell]);
    }
}

}  // namespace

Raster<std::uint8_t> known_pixels(const Disparities16& map, ThreadPool& pool) {
    Raster<std::uint8_t> known(map.width(), map.height(), 0);
    for_each_row(pool, map.height(), [&](int y) {
        for (int x = 0; x < map.width(); ++x) known.view().at(x, y) = map.view().at(x, y) != kUnknown16;
    });
    return known;
}

RefinedMap refine(const RefineInput& input, const ConsistencyConfig& config, ThreadPool& pool) {
    const PairColors& colors = input.colors;
    TrustedMatches matches = find_trusted_matches(input.views, config, pool);
    Raster<std::uint8_t> matched = known_pixels(matches.left, pool);
    if (input.half_size) add_half_size_matches(*input.half_size, config.min_px, matches, pool);
    Disparities16 map = fill_unknown(
        {matches, find_slopes(matches.left, step::kFarSlopes_px, pool), colors, config.min_px}, pool);
    raise_frame_segments(input.frame_segments, std::as_const(matches.left).view(), map.view());
    const ColorPlanes& left = colors.left;
    const ColorPlanes hole_colors = blurred(left, pool);
    for (int round = 0; round < step::kVoteRounds; ++round) {
        const bool first_round = round == 0;
        const Slopes slopes =
            find_slopes(map, first_round ? step::kFarSlopes_px : step::kNearSlopes_px, pool);
        const VoterInput voters{map, colors, matches.nearest_seen, config.min_px};
        const Raster<std::uint8_t> weights =
            first_round ? first_round_weights(voters, matched, pool) : later_weights(voters, pool);
        Raster<VoteWindow> windows = near_discontinuities(map, pool);
        if (first_round) open_holes(weights, windows, pool);
        map = take_votes({map, slopes, left, hole_colors, matches.nearest_seen, weights, config.min_px},
                         windows, pool);
    }
    for (int round = 0; round < step::kSideRounds; ++round)
        map = choose_sides({map, left, colors.right, matches.nearest_seen, config.min_px}, pool);
    return {smoothed(median_filtered(map, pool), left, pool), std::move(matched)};
}

}  // namespace hexrelief::matching
