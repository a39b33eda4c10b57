// Which edges of triangles are open, as SideFinder::open_edges finds them.
#pragma once

#include <cstdint>

#include "cuda/sheet_sides.cuh"

namespace hexrelief::cuda {

class DeviceVotes {
  public:
    __device__ DeviceVotes(const SheetState& s, const SideArrays& a) : s_(s), a_(a), view_(s.view()) {}

    // After an update.
    template <typename Crew>
    __device__ void open_edges(Crew& crew) const {
        const unsigned count = s_.totals->triangles;
        if (crew.thread() == 0) a_.counts->opened = 1;
        for (unsigned start = crew.thread() / 32 * 32; start < count; start += crew.threads()) {
            const unsigned t = start + crew.lane();
            put_on_list(a_.list, a_.counts->voting, t, t < count && has_votes(t));
        }
        crew.wait();
        const unsigned listed = a_.counts->voting;
        for (unsigned i = crew.thread() / 32; i < listed; i += crew.threads() / 32)
            vote(crew.lane(), a_.list[i]);
        crew.wait();
    }

    // Whether surfaces differ without the jump between them.
    __device__ bool may_differ(unsigned a, unsigned b) const {
        return step::may_differ(view_, s_.sides.anchors[a], s_.sides.anchors[b], s_.totals->jump_px);
    }
    // By a warp: without pixels along the edge, whether a jump parts the triangles' own pixels.
    __device__ bool differ(unsigned lane, unsigned a, unsigned b) const {
        if (!may_differ(a, b)) return false;
        const step::Way way = step::way_between_pixels(view_, s_.sides.anchors[a], s_.sides.anchors[b]);
        bool met = false;
        step::Crack crack;
        for (int k = static_cast<int>(lane); k < way.steps; k += 32)
            met |= step::steps_over(view_, step::pixel_after(view_, way, k),
                                    step::pixel_after(view_, way, k + 1), crack);
        return __any_sync(kAllLanes, met);
    }

  private:
    __device__ bool is_plain(unsigned t) const {
        constexpr std::uint8_t kBoth = SideArrays::kPlain | SideArrays::kAny;
        return (a_.states[t] & kBoth) == kBoth;
    }
    // Whether pixels are to say which edges of the triangle are open; if not, those that are to be looked at
    // are closed.
    __device__ bool has_votes(unsigned t) const {
        const auto& n = s_.lattice.neighbours[t];
        const std::int32_t around[3] = {n[0], n[1], n[2]};
        bool renewed = (a_.marks[t] & SideArrays::kToVote) != 0, plain = is_plain(t);
        for (const std::int32_t u : around)
            if (u >= 0) {
                renewed |= (a_.marks[u] & SideArrays::kToVote) != 0;
                plain &= is_plain(static_cast<unsigned>(u));
            }
        if (renewed && plain)
            for (int k = 0; k < 3; ++k) s_.sides.open[t][k] = 0;
        return renewed && !plain;
    }
    // Pairs of neighbouring pixels across each edge say whether its two sides are one surface.
    __device__ void vote(unsigned lane, unsigned t) const {
        const std::int32_t around[3] = {s_.lattice.neighbours[t][0], s_.lattice.neighbours[t][1],
                                        s_.lattice.neighbours[t][2]};
        int votes[3] = {0, 0, 0}, pairs[3] = {0, 0, 0};
        const Vec2f* const p = a_.corners[t];
        TriangleWarp pixels(view_, p[0], p[1], p[2]);
        pixels.each_rows([&](const LaneRows& rows) {
            pixels.each_pixel(rows, [&](const LanePixel& pixel) {
                const auto row_of = [&](unsigned from) {
                    return RowRange{__shfl_sync(kAllLanes, rows.run.first, from),
                                    __shfl_sync(kAllLanes, rows.run.end, from)};
                };
                const RowRange upper = row_of(pixel.row - 1), lower = row_of(pixel.row + 1);
                if (!pixel.valid) return;
                const std::uint32_t i = pixel.index, width = view_.width;
                const int x = pixel.x, y = pixel.y;
                const bool is_own = a_.places[i] == step::place_of(t, true);
                const auto pair = [&](bool there, std::uint32_t j, std::uint32_t jump_at, std::uint8_t jump) {
                    if (!there) return;
                    const std::uint32_t other = a_.places[j];
                    const int vote =
                        step::pair_vote(is_own, step::is_on_side(other), view_.flags[jump_at] & jump);
                    if (other == 0 || vote == 0) return;
                    bool found = false;  // the first of equal neighbours, as there may be none
                    HEXRELIEF_UNROLL
                    for (int k = 0; k < 3; ++k)
                        if (!found && around[k] >= 0 &&
                            step::belongs(other, static_cast<std::uint32_t>(around[k]))) {
                            votes[k] += vote;
                            ++pairs[k];
                            found = true;
                        }
                };
                pair(x == pixel.first && x > 0, i - 1, i - 1, step::kJumpRight);
                pair(x == pixel.end - 1 && x + 1 < view_.width, i + 1, i, step::kJumpRight);
                pair(y > 0 && !(x >= upper.first && x < upper.end), i - width, i - width, step::kJumpDown);
                pair(y + 1 < view_.height && !(x >= lower.first && x < lower.end), i + width, i,
                     step::kJumpDown);
            });
        });
        HEXRELIEF_UNROLL
        for (int k = 0; k < 3; ++k) {
            const int all = sum_of_lanes(pairs[k]), sum = sum_of_lanes(votes[k]);
            bool open = false;
            if (around[k] >= 0) open = all > 0 ? sum > 0 : differ(lane, t, static_cast<unsigned>(around[k]));
            if (lane == 0) s_.sides.open[t][k] = open;
        }
    }

    const SheetState& s_;
    const SideArrays& a_;
    step::PixelView view_;
};

// As SideFinder::open_edges; only after an update.
template <typename Crew>
__device__ void open_edges(Crew& crew, const SheetState& s, const SideArrays& a) {
    DeviceVotes(s, a).open_edges(crew);
}

}  // namespace hexrelief::cuda
