#include "cuda/surface/topology/label_triangles.h"

#include "cuda/common/grid.cuh"
#include "cuda/common/triangle_groups.cuh"
#include "cuda/surface/topology/surface_difference.cuh"
#include "cuda/surface/topology/triangle_lists.cuh"
#include "mesher/surface/topology/label_triangles_step.h"

namespace hexrelief::cuda {
namespace {

class DeviceVotes {
  public:
    __device__ DeviceVotes(const SurfaceState& s, const LabelArrays& a) : s_(s), a_(a), view_(s.view()) {}

    // Votes on the edges around triangles with new labels; to be called after an update.
    __device__ void open_edges(const CooperativeGrid& grid) const {
        const unsigned count = s_.counts->triangles, vote_number = s_.counts->votes + 1;
        const TriangleList list{a_.lists[0], s_.sizes.most_triangles};
        HEXRELIEF_ROLLED
        for (unsigned start = grid.warp() * 32; start < count; start += grid.threads()) {
            const unsigned t = start + grid.lane(), rows = t < count ? a_.row_counts[t] : 0;
            list.put(a_.counts->voting, t, t < count && has_votes(t, vote_number), rows > kLeastGroup);
        }
        grid.wait();
        if (grid.thread() == 0) s_.counts->votes = vote_number;
        const LabelArrays::Listed voting = a_.counts->voting;
        each_by_group(grid, voting.many, voting.few, kLeastGroup, a_.counts->taken + 2,
                      [&](unsigned i, bool has, const TriangleLanes& group) {
                          vote(has ? list.at(voting, i) : 0, has, group);
                      });
        grid.wait();
    }

  private:
    __device__ bool is_plain(unsigned t) const {
        constexpr std::uint8_t kBoth = LabelArrays::kPlain | LabelArrays::kAny;
        return (a_.states[t] & kBoth) == kBoth;
    }
    // True if pixels have to vote on the triangle's edges. If its labels are new but no vote is
    // needed, closes its edges.
    __device__ bool has_votes(unsigned t, unsigned vote_number) const {
        const auto& n = s_.lattice.neighbours[t];
        const std::int32_t around[3] = {n[0], n[1], n[2]};
        bool renewed = a_.marks[t] == vote_number, plain[3];
        HEXRELIEF_UNROLL
        for (int k = 0; k < 3; ++k) {
            const unsigned other = around[k] >= 0 ? static_cast<unsigned>(around[k]) : t;
            renewed |= a_.marks[other] == vote_number;
            plain[k] = is_plain(other);
        }
        const bool closed = step::is_closed_without_vote(is_plain(t), plain);
        if (renewed && closed)
            for (int k = 0; k < 3; ++k) s_.labels.open[t][k] = 0;
        return renewed && !closed;
    }

    // Two neighbouring pixels, one of them the triangle's, and the pixel and flag of
    // a discontinuity between them.
    struct Pair {
        std::uint32_t own, other, discontinuity_at;
        std::uint8_t discontinuity;
        bool there;
    };
    // The pairs across the triangle's edges, of a row and the row above: first those between the two rows in
    // columns that only one of them covers, then those at both ends of the row.
    struct RowPairs {
        const step::PixelView& view;
        surface::PixelRun upper, lower;
        int first, first_end, second, second_end;  // columns that only one of the rows covers

        __device__ RowPairs(const step::PixelView& v, const surface::PixelRun& u, const surface::PixelRun& l)
            : view(v), upper(u), lower(l) {
            const bool meet = max(u.first, l.first) < min(u.end, l.end);
            first = meet ? min(u.first, l.first) : u.first;
            first_end = meet ? max(u.first, l.first) : max(u.first, u.end);
            second = meet ? min(u.end, l.end) : l.first;
            second_end = meet ? max(u.end, l.end) : max(l.first, l.end);
        }
        __device__ int count() const { return first_end - first + second_end - second + 2; }
        __device__ Pair at(int k) const {
            const int of_first = first_end - first, of_columns = of_first + second_end - second;
            const std::uint32_t width = static_cast<std::uint32_t>(view.width);
            if (k < of_columns) {
                const int x = k < of_first ? first + k : second + (k - of_first);
                const std::uint32_t low = static_cast<std::uint32_t>(view.index(x, lower.y)),
                                    high = low - width;
                const bool is_lower = x >= lower.first && x < lower.end;
                return {is_lower ? low : high, is_lower ? high : low, high, step::kDiscontinuityDown,
                        is_lower ? lower.y > 0 : lower.y < view.height};
            }
            const bool right = k > of_columns, own = lower.first < lower.end;
            const std::uint32_t i =
                static_cast<std::uint32_t>(view.index(right ? lower.end - 1 : lower.first, lower.y));
            return {i, right ? i + 1 : i - 1, right ? i : i - 1, step::kDiscontinuityRight,
                    k < of_columns + 2 && own && (right ? lower.end < view.width : lower.first > 0)};
        }
    };
    // Counts the votes of pairs of neighbouring pixels across each edge of a triangle, and
    // opens or closes it.
    __device__ void vote(unsigned t, bool has, const TriangleLanes& group) const {
        constexpr int kAtOnce = 4;  // because loads take long
        const auto& n = s_.lattice.neighbours[t];
        const std::int32_t around[3] = {n[0], n[1], n[2]};
        const step::VoterIds voters = step::voters_of(t, around);
        step::EdgeVotes votes;
        const Vec2f* const p = a_.corners[t];
        each_row_by_group(
            group, {view_.width, view_.height, p[0], p[1], p[2]}, has, 1, [&](const GroupRow& row) {
                if (!has) return;
                const RowPairs pairs(view_, row.above, row.run);
                const int count = pairs.count();
                HEXRELIEF_ROLLED
                for (int start = 0; start < count; start += kAtOnce) {
                    std::uint32_t own[kAtOnce], other[kAtOnce];
                    bool parted[kAtOnce];
                    HEXRELIEF_UNROLL
                    for (int k = 0; k < kAtOnce; ++k) {
                        const Pair pair = pairs.at(start + k);
                        own[k] = pair.there ? a_.triangle_ids[pair.own] : 0;
                        other[k] = pair.there ? a_.triangle_ids[pair.other] : 0;
                        parted[k] = pair.there && (view_.flags[pair.discontinuity_at] & pair.discontinuity);
                    }
                    HEXRELIEF_UNROLL
                    for (int k = 0; k < kAtOnce; ++k)
                        step::add_vote(votes, voters, own[k], other[k], parted[k]);
                }
            });
        unsigned opened = 0, silent = 0;  // bits of edges; silent: edges without votes
        HEXRELIEF_UNROLL
        for (int k = 0; k < 3; ++k) {
            const int for_it = group.sum(votes.open(k)), against = group.sum(votes.closed(k));
            if (for_it > against) opened |= 1u << k;
            if (has && around[k] > static_cast<std::int32_t>(t) && for_it == 0 && against == 0)
                silent |= 1u << k;
        }
        HEXRELIEF_ROLLED
        for (int k = 0; k < 3; ++k) {
            const std::int32_t u = k == 0 ? around[0] : k == 1 ? around[1] : around[2];
            const bool is_silent = silent >> k & 1;
            if (!__any_sync(kAllLanes, is_silent)) continue;
            if (differ(s_, group, is_silent, t, is_silent ? static_cast<unsigned>(u) : t)) opened |= 1u << k;
        }
        if (has && group.lane < 3) s_.labels.open[t][group.lane] = opened >> group.lane & 1;
    }

    const SurfaceState& s_;
    const LabelArrays& a_;
    step::PixelView view_;
};

__global__ void __launch_bounds__(kGridThreads, 1)
    open_edges_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ LabelArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    DeviceVotes(s, a).open_edges(grid);
}

}  // namespace

void open_edges(const Launch& launch, const SurfaceState& s, const LabelArrays& a) {
    launch_cooperative(launch, open_edges_kernel, 0, "opening edges", s, a);
}

}  // namespace hexrelief::cuda
