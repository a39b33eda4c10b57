#include "pipeline/matching/refine/votes.h"

#include <algorithm>
#include <cstdlib>

#include "pipeline/matching/common/color_rows.h"
#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::matching {
namespace {

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

}  // namespace

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
