#include "pipeline/matching/refine/votes.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/refine/match_colors.h"
#include "pipeline/matching/refine/side_step.h"
#include "pipeline/matching/refine/vote_step.h"
#include "pipeline/matching/refine/voter_step.h"

namespace hexrelief::matching {
namespace {

struct SideViews {
    DisparityView map;
    ColorView left, right;
    RasterView<const std::int32_t> nearest_seen;
    int min_px;
};

HEXRELIEF_SMALL_VECTORS void find_sides(DisparityView map, int x0, int y, int count,
                                        step::Sides* __restrict sides) {
    const std::int16_t* row = map.row(y) + x0;
    for (int x = 0; x < count; ++x) sides[x] = step::sides_at(row + x, map.stride);
}

void choose_in_row(const SideViews& in, int y, std::int16_t* out) {
    const std::int16_t* row = in.map.row(y);
    step::Sides sides[kBlock];
    for (int x0 = 0; x0 < in.map.width; x0 += kBlock) {
        const int count = std::min(kBlock, in.map.width - x0);
        find_sides(in.map, x0, y, count, sides);
        for (int x = x0; x < x0 + count; ++x) {
            const step::Sides& here = sides[x - x0];
            if (!step::discontinuous(row[x], here.farthest) && !step::discontinuous(row[x], here.nearest))
                continue;
            const step::RowSite site{x, in.map.width, in.min_px, in.nearest_seen.row(y)};
            out[x] = step::better_side(site, row[x], here, [&](int disparity) {
                return match_difference(in.left, in.right, x, y,
                                        step::position_in_right(x, in.min_px, disparity));
            });
        }
    }
}

constexpr int kLanes = 32;  // number of adjacent pixels whose medians are computed at once

// The input for one kind of window.
struct VoteViews {
    bool hole;
    ColorView colors;
    DisparityView map, slope_x, slope_y;
    RasterView<const std::int32_t> nearest_seen;
    RasterView<const std::uint8_t> weights;
    int min_px;
};

// The votes on kLanes pixels.
struct Ballot {
    alignas(64) std::int16_t disparities[step::kMostVotes][kLanes];
    alignas(64) std::uint16_t weights[step::kMostVotes][kLanes];
    alignas(64) std::uint16_t total[kLanes] = {};
    alignas(64) std::int16_t lo[kLanes], hi[kLanes];  // least and largest disparity with a weight
    int votes = 0;
};

// Adds the vote of one voter for each pixel, the one (dx, dy) px away.
HEXRELIEF_INLINED void cast_votes(const VoteViews& in, int x0, int y, int dx, int dy,
                                  std::uint16_t at_distance, Ballot& ballot) {
    const std::int16_t* voters = in.map.row(y + dy) + x0 + dx;
    const std::int16_t* slope_x = in.slope_x.row(y + dy) + x0 + dx;
    const std::int16_t* slope_y = in.slope_y.row(y + dy) + x0 + dx;
    const std::uint8_t* own_weights = in.weights.row(y + dy) + x0 + dx;
    const std::int32_t* nearest = in.nearest_seen.row(y);
    std::int16_t* __restrict disparities = ballot.disparities[ballot.votes];
    std::uint16_t* __restrict weights = ballot.weights[ballot.votes];
    ++ballot.votes;

    alignas(64) std::uint8_t steps[kLanes];
    color_steps(in.colors, x0, y, dx, dy, kLanes, steps);
    alignas(64) std::uint16_t likeness[kLanes];
    if (in.hole)
        for (int x = 0; x < kLanes; ++x) likeness[x] = step::hole_likeness<std::uint16_t>(steps[x]);
    else
        for (int x = 0; x < kLanes; ++x) likeness[x] = step::near_likeness<std::uint16_t>(steps[x]);
    for (int x = 0; x < kLanes; ++x)
        weights[x] =
            step::vote_weight<std::uint16_t>(likeness[x], at_distance, own_weights[x], voters[x] >= 0);
    const auto along_x = static_cast<std::int16_t>(dx), along_y = static_cast<std::int16_t>(dy);
    for (int x = 0; x < kLanes; ++x)
        disparities[x] =
            step::vote<std::int16_t>(voters[x], step::plane_change(slope_x[x], slope_y[x], along_x, along_y));
    alignas(64) std::int32_t columns[kLanes], seen[kLanes];
    for (int x = 0; x < kLanes; ++x) {
        const int column = step::matching_column(x0 + x, in.min_px, disparities[x]);
        columns[x] = (column >= 0) & (column < in.map.width) ? column : -1;  // the border hides nothing
    }
    for (int x = 0; x < kLanes; ++x) seen[x] = nearest[columns[x]];
    for (int x = 0; x < kLanes; ++x) {
        const std::uint16_t weight = step::hides(seen[x], disparities[x]) ? std::uint16_t{0} : weights[x];
        const std::int16_t low = weight ? disparities[x] : std::int16_t{INT16_MAX};
        const std::int16_t high = weight ? disparities[x] : std::int16_t{0};
        weights[x] = weight;
        ballot.total[x] = static_cast<std::uint16_t>(ballot.total[x] + weight);
        ballot.lo[x] = low < ballot.lo[x] ? low : ballot.lo[x];
        ballot.hi[x] = high > ballot.hi[x] ? high : ballot.hi[x];
    }
}

// Narrows lo and hi to the medians.
HEXRELIEF_INLINED void find_medians(Ballot& ballot) {
    for (;;) {
        alignas(64) std::uint16_t sum[kLanes] = {};
        alignas(64) std::int16_t middle[kLanes];
        int open = 0;
        for (int x = 0; x < kLanes; ++x) {
            middle[x] = step::middle(ballot.lo[x], ballot.hi[x]);
            open |= ballot.lo[x] < ballot.hi[x];
        }
        if (!open) return;
        for (int k = 0; k < ballot.votes; ++k) {
            const std::int16_t* disparities = ballot.disparities[k];
            const std::uint16_t* weights = ballot.weights[k];
            for (int x = 0; x < kLanes; ++x) {
                const auto counts = static_cast<std::uint16_t>(step::mask_of(disparities[x] <= middle[x]));
                sum[x] = static_cast<std::uint16_t>(sum[x] + (weights[x] & counts));
            }
        }
        for (int x = 0; x < kLanes; ++x) step::narrow(sum[x], ballot.total[x], ballot.lo[x], ballot.hi[x]);
    }
}

// Returns the medians of the pixels (x0 .. x0 + kLanes - 1, y), of which some may lie in the border.
HEXRELIEF_SMALL_VECTORS void vote_on_run(const VoteViews& in, int x0, int y,
                                         std::int16_t* __restrict medians) {
    const step::VoteReach reach = in.hole ? step::kHoleVotes : step::kNearVotes;
    const int stride = reach.stride;
    Ballot ballot;
    std::fill_n(ballot.lo, kLanes, std::int16_t{INT16_MAX});
    std::fill_n(ballot.hi, kLanes, std::int16_t{0});
    for (int j = -reach.radius; j <= reach.radius; ++j) {
        if (y + j * stride < 0 || y + j * stride >= in.map.height) continue;
        for (int i = -reach.radius; i <= reach.radius; ++i) {
            if (reach.dark_only && !step::is_dark(i, j)) continue;
            const int ring = std::max(std::abs(i), std::abs(j));
            cast_votes(in, x0, y, i * stride, j * stride, step::distance_weight(in.hole, ring), ballot);
        }
    }
    for (int x = 0; x < kLanes; ++x) ballot.lo[x] = std::min(ballot.lo[x], ballot.hi[x]);
    find_medians(ballot);
    for (int x = 0; x < kLanes; ++x) medians[x] = ballot.total[x] ? ballot.lo[x] : in.map.at(x0 + x, y);
}

void vote_on_row(const VoteViews& in, const VoteWindow* windows, VoteWindow window, int y,
                 std::int16_t* out) {
    for (int x0 = 0; x0 < in.map.width; ++x0) {
        if (windows[x0] != window) continue;
        std::int16_t medians[kLanes];
        vote_on_run(in, x0, y, medians);
        const int end = std::min(in.map.width, x0 + kLanes);
        for (int x = x0; x < end; ++x)
            if (windows[x] == window) out[x] = medians[x - x0];
        x0 = end - 1;
    }
}

// The sides of the discontinuities in each column of a row of blocks.
struct ColumnSides {
    std::vector<std::int16_t> farthest, nearest;
};

// Adds the pixels of a row.
HEXRELIEF_SMALL_VECTORS void add_row(DisparityView map, int y, ColumnSides& sides) {
    const std::int16_t* const row = map.row(y);
    std::int16_t *const farthest = sides.farthest.data(), *const nearest = sides.nearest.data();
    for (int x = 0; x < map.width; ++x) {
        const std::int16_t is_side = step::mask_of(step::beside_discontinuity(row + x, map.stride));
        const auto far = static_cast<std::int16_t>(is_side ? row[x] : step::no_sides().farthest);
        const auto near = static_cast<std::int16_t>(is_side ? row[x] : step::no_sides().nearest);
        farthest[x] = std::min(farthest[x], far);
        nearest[x] = std::max(nearest[x], near);
    }
}

// The sides of each block's discontinuities, widened by those of the blocks around it.
Raster<step::Sides> sides_of_blocks(const Disparities16& map, ThreadPool& pool) {
    constexpr int kSide = step::kSidesBlock_px;
    const DisparityView view = map.view();
    const auto width = static_cast<std::size_t>(view.width);
    const int columns = (view.width + kSide - 1) / kSide, rows = (view.height + kSide - 1) / kSide;
    Raster<step::Sides> own(columns, rows, step::no_sides()), wide = own;
    for_each_row(pool, rows, [&](int row) {
        ColumnSides sides{std::vector(width, step::no_sides().farthest),
                          std::vector(width, step::no_sides().nearest)};
        for (int y = row * kSide; y < std::min((row + 1) * kSide, view.height); ++y) add_row(view, y, sides);
        for (std::size_t x = 0; x < width; ++x) {
            step::Sides& block = own.view().row(row)[x / kSide];
            block = step::both(block, {sides.farthest[x], sides.nearest[x]});
        }
    });
    for_each_row(pool, rows, [&](int row) {
        for (int column = 0; column < columns; ++column)
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    wide.view().at(column, row) =
                        step::both(wide.view().at(column, row), own.view().at(column + i, row + j));
    });
    return wide;
}

Raster<step::Certainty> find_certainty(const VoterInput& input, ThreadPool& pool) {
    const DisparityView map = input.map.view();
    const ColorView left = view_of(input.colors.left), right = view_of(input.colors.right);
    const Raster<step::Sides> sides = sides_of_blocks(input.map, pool);
    Raster<step::Certainty> result(map.width, map.height, step::Certainty::right);
    for_each_row(pool, map.height, [&](int y) {
        const step::Sides* const row = sides.view().row(y / step::kSidesBlock_px);
        for (int x = 0; x < map.width; ++x) {
            const step::Sides& here = row[x / step::kSidesBlock_px];
            if (here.nearest < 0) continue;
            const step::RowSite site{x, map.width, input.min_px, input.nearest_seen.view().row(y)};
            result.view().at(x, y) = step::certainty(site, map.at(x, y), here, [&](int disparity) {
                return match_difference(left, right, x, y,
                                        step::position_in_right(x, input.min_px, disparity));
            });
        }
    });
    return result;
}

}  // namespace

Disparities16 choose_sides(const SideInput& input, ThreadPool& pool) {
    Disparities16 result = input.map;
    const SideViews views{input.map.view(), view_of(input.left), view_of(input.right),
                          input.nearest_seen.view(), input.min_px};
    for_each_row(pool, result.height(), [&](int y) { choose_in_row(views, y, result.view().row(y)); });
    return result;
}

Raster<std::uint8_t> first_round_weights(const VoterInput& input, const Raster<std::uint8_t>& matched,
                                         ThreadPool& pool) {
    const int width = input.map.width(), height = input.map.height();
    const ColorView left = view_of(input.colors.left), right = view_of(input.colors.right);
    const Raster<step::Certainty> certainty = find_certainty(input, pool);
    Raster<std::uint8_t> weights(width, height, step::kMatchedWeight);
    for_each_row(pool, height, [&](int y) {
        const step::Certainty* const certain = certainty.view().row(y);
        for (int x = 0; x < width; ++x) {
            if (matched.view().at(x, y) && certain[x] == step::Certainty::right) continue;
            const int disparity = input.map.view().at(x, y);
            const step::RowSite site{x, width, input.min_px, input.nearest_seen.view().row(y)};
            weights.view().at(x, y) = step::filled_weight(site, disparity, left.channels > 1, [&] {
                return window_difference(left, right, x, y,
                                         step::position_in_right(x, input.min_px, disparity));
            });
        }
    });
    return weights;
}

Raster<std::uint8_t> later_weights(const VoterInput& input, ThreadPool& pool) {
    const Raster<step::Certainty> certainty = find_certainty(input, pool);
    Raster<std::uint8_t> weights(input.map.width(), input.map.height(), 0);
    for_each_row(pool, input.map.height(), [&](int y) {
        for (int x = 0; x < input.map.width(); ++x)
            weights.view().at(x, y) = step::later_weight(certainty.view().at(x, y));
    });
    return weights;
}

Raster<VoteWindow> near_discontinuities(const Disparities16& map, ThreadPool& pool) {
    const int width = map.width(), height = map.height();
    Raster<std::uint8_t> steps(width, height, 0), beside(width, height, 0);
    Raster<VoteWindow> result(width, height, VoteWindow::none);
    const DisparityView view = map.view();
    for_each_row(pool, height, [&](int y) {
        const std::int16_t* const row = view.row(y);
        for (int x = 0; x < width; ++x)
            steps.view().at(x, y) = step::beside_discontinuity(row + x, view.stride);
    });
    for_each_row(pool, height, [&](int y) {
        const std::uint8_t* from = steps.view().row(y);
        std::uint8_t* to = beside.view().row(y);
        for (int i = -step::kNear_px; i <= step::kNear_px; ++i)
            for (int x = 0; x < width; ++x) to[x] |= from[x + i];
    });
    for_each_row(pool, height, [&](int y) {
        VoteWindow* to = result.view().row(y);
        for (int j = -step::kNear_px; j <= step::kNear_px; ++j) {
            const std::uint8_t* from = beside.view().row(y + j);
            for (int x = 0; x < width; ++x) to[x] = from[x] ? VoteWindow::near : to[x];
        }
    });
    return result;
}

void open_holes(const Raster<std::uint8_t>& weights, Raster<VoteWindow>& windows, ThreadPool& pool) {
    for_each_row(pool, weights.height(), [&](int y) {
        for (int x = 0; x < weights.width(); ++x)
            if (step::is_hole(weights.view().at(x, y))) windows.view().at(x, y) = VoteWindow::hole;
    });
}

Disparities16 take_votes(const VoteInput& input, const Raster<VoteWindow>& windows, ThreadPool& pool) {
    Disparities16 result = input.map;
    const auto views_of = [&](bool hole, const ColorPlanes& colors) {
        return VoteViews{hole,
                         view_of(colors),
                         input.map.view(),
                         input.slopes.x.view(),
                         input.slopes.y.view(),
                         input.nearest_seen.view(),
                         input.weights.view(),
                         input.min_px};
    };
    const VoteViews near = views_of(false, input.colors), hole = views_of(true, input.hole_colors);
    for_each_row(pool, result.height(), [&](int y) {
        const VoteWindow* row = windows.view().row(y);
        vote_on_row(near, row, VoteWindow::near, y, result.view().row(y));
        vote_on_row(hole, row, VoteWindow::hole, y, result.view().row(y));
    });
    return result;
}

}  // namespace hexrelief::matching
