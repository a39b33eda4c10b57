#include "cuda/surface/topology/snap_vertices.h"

#include "cuda/common/grid.cuh"
#include "cuda/common/relaxed.cuh"
#include "cuda/surface/pixels/crack_query.cuh"

namespace hexrelief::cuda {
namespace {

// A warp moves a vertex as soon as the neighbours that come before it have moved, without a barrier between
// vertices. There is a single copy of the code for this, which stays in the instruction cache.
class DeviceSnapper {
  public:
    __device__ DeviceSnapper(const SurfaceState& s, const SnapArrays& a, unsigned lane)
        : s_(s),
          a_(a),
          query_(WarpQuery::of(s, a.silhouettes, lane)),
          lattice_{s.sizes.columns, s.sizes.rows} {}

    __device__ void run(const CooperativeGrid& grid) const {
        if (grid.thread() < 3) a_.counts[grid.thread()] = 0;
        if (grid.thread() == 0) *a_.silhouettes.count = 0;
        grid.each(s_.sizes.vertices(), [&](unsigned v) {
            const Vec2f p = s_.lattice.points[v];
            a_.vertices[v] = {p.x, p.y, -1, 0};
            a_.seen[v] = kFresh;
            a_.targets[v] = p;  // read here, so that it is cached when it is needed
            s_.lattice.on_silhouette[v] = 0;
        });
        find_silhouettes(grid, s_, a_.silhouettes);
        grid.each(s_.sizes.vertices(), [&](unsigned v) { list_query(v); });
        HEXRELIEF_ROLLED
        for (int listing = 1; listing >= 0; --listing) {
            go_through(grid, listing);
            grid.wait();
        }
    }

  private:
    // Bits of SnapArrays::seen: those of the neighbours, this one, and 1 + the edge to
    // which the target belongs.
    static constexpr unsigned kFresh = 128, kTargetShift = 8;

    __device__ SnapVertex at(unsigned v) const { return load_relaxed(a_.vertices + v); }
    __device__ static bool within(float share) { return share >= 0 && share <= step::kSnapReach; }

    // Calls visit(u, k, the vertex of u) for the neighbours u.
    template <typename Visit>
    __device__ void each_neighbour(unsigned v, const Visit& visit) const {
        const int row = static_cast<int>(v / s_.sizes.columns),
                  column = static_cast<int>(v) - row * s_.sizes.columns;
        SnapVertex others[6];
#pragma unroll
        for (int k = 0; k < 6; ++k) {  // all loads before the first use
            const int u = step::neighbour_at(lattice_, column, row, k);
            others[k] = at(u < 0 ? v : static_cast<unsigned>(u));
        }
#pragma unroll
        for (int k = 0; k < 6; ++k) {
            const int u = step::neighbour_at(lattice_, column, row, k);
            if (u >= 0) visit(static_cast<unsigned>(u), k, others[k]);
        }
    }
    // Lists a vertex if silhouettes are around it.
    __device__ void list_query(unsigned v) const {
        Vec2f lower = at(v).point(), upper = lower;
        each_neighbour(v, [&](unsigned, int, const SnapVertex& other) {
            lower = {step::min_of(lower.x, other.x), step::min_of(lower.y, other.y)};
            upper = {step::max_of(upper.x, other.x), step::max_of(upper.y, other.y)};
        });
        if (step::may_cross(s_.tiles(), lower, upper)) {
            a_.queries[atomicAdd(a_.counts + 1, 1u)] = v;
            return;
        }
        for (int k = 0; k < 6; ++k) a_.shares[v][k] = -1;
        a_.seen[v] = 0;
    }

    // Goes through the candidates: each lane checks which neighbours its candidate has to wait for, and the
    // warp visits those that wait for none. Queries (listing) never wait: each warp takes the next one.
    __device__ void go_through(const CooperativeGrid& grid, bool listing) const {
        const unsigned count = a_.counts[listing ? 1 : 0], warps = grid.warps();
        const auto next = [&](unsigned first) {
            if (!listing || count <= warps) return first + 32 * warps;
            const unsigned taken = query_.lane == 0 ? atomicAdd(a_.counts + 2, 1u) : 0;
            return warps + __shfl_sync(kAllLanes, taken, 0);
        };
        for (bool more = true; more;) {
            more = false;
            HEXRELIEF_ROLLED
            for (unsigned first = grid.warp(); first < count; first = next(first)) {
                const unsigned i = listing ? (query_.lane == 0 ? first : count) : first + query_.lane * warps;
                const unsigned v = i >= count ? 0 : listing ? a_.queries[i] : a_.candidates[i];
                bool open = i < count;
                unsigned waits_for = 0;  // bits of neighbours
                if (open && !listing) {
                    const SnapVertex own = at(v);
                    open = own.done == 0;
                    each_neighbour(v, [&](unsigned u, int k, const SnapVertex& other) {
                        if (within(other.share) && other.done == 0 &&
                            step::goes_before(s_.part, other.share, u, own.share, v))
                            waits_for |= 1u << k;
                    });
                }
                // Repeated while others may have moved in the meantime; but with more than one round of
                // items, a vertex of the next round may be waited for.
                HEXRELIEF_ROLLED
                for (;;) {
                    const unsigned going = __ballot_sync(kAllLanes, open && !waits_for);
                    open = open && waits_for;
                    HEXRELIEF_ROLLED
                    for (unsigned left = going; left; left &= left - 1)
                        visit(__shfl_sync(kAllLanes, v, __ffs(left) - 1), listing);
                    if (!__any_sync(kAllLanes, open)) break;
                    if (!going && count > 32 * warps) break;
                    waits_for = open ? still(v, waits_for) : 0;
                }
                more |= __any_sync(kAllLanes, open);
            }
        }
    }
    // Returns which of the neighbours are not done yet.
    __device__ unsigned still(unsigned v, unsigned neighbours) const {
        const int row = static_cast<int>(v / s_.sizes.columns),
                  column = static_cast<int>(v) - row * s_.sizes.columns;
        unsigned dones[6];
#pragma unroll
        for (int k = 0; k < 6; ++k) {  // all loads before the first use
            const unsigned u = neighbours >> k & 1u
                                   ? static_cast<unsigned>(step::neighbour_at(lattice_, column, row, k))
                                   : v;
            dones[k] = load_relaxed(&a_.vertices[u].done);
        }
#pragma unroll
        for (int k = 0; k < 6; ++k)
            if (dones[k] != 0) neighbours &= ~(1u << k);
        return neighbours;
    }

    // Visits a vertex by the whole warp. When listing, it only finds out whether the vertex is a candidate.
    __device__ void visit(unsigned v, bool listing) const {
        const int row = static_cast<int>(v / s_.sizes.columns),
                  column = static_cast<int>(v) - row * s_.sizes.columns;
        SnapVertex own = at(v);
        const Vec2f from = own.point();
        Corners corners{{}, -1};
        if (!listing) corners = corners_around(v, column, row);
        Vec2f target = a_.targets[v];
        Around around = refresh(v, column, row, from, !listing);
        own.share = around.share;
        const bool goes = within(own.share);
        if (goes && !around.has_target()) {
            target = step::nearest_silhouette(query_, from, around.crossing);
            around.seen = (around.seen & 255u) | around.edge_bits();
            if (query_.lane == 0) a_.targets[v] = target;
        }
        if (!listing) {
            own.done = SnapVertex::kStayed;
            Vec2f to{};
            if (goes && find_place(corners, from, target, around.crossing, to)) {
                own = {to.x, to.y, -1, SnapVertex::kSnapped};
                if (query_.lane == 0) {
                    s_.lattice.points[v] = to;
                    s_.lattice.on_silhouette[v] = 1;
                }
            }
        }
        if (query_.lane != 0) return;
        a_.seen[v] = static_cast<std::uint16_t>(around.seen);
        store_relaxed(a_.vertices + v, own);
        if (listing && goes) a_.candidates[atomicAdd(a_.counts, 1u)] = v;
    }

    struct Around {
        int edge;        // the edge with the least share
        float share;     // below 0: none
        Vec2f crossing;  // the crossing at that share
        unsigned seen;   // as SnapArrays::seen

        __device__ unsigned edge_bits() const { return static_cast<unsigned>(edge + 1) << kTargetShift; }
        __device__ bool has_target() const { return seen >> kTargetShift == edge_bits() >> kTargetShift; }
    };
    // Finds the crossings of the edges from v, at p, with silhouettes: lane k holds edge k, and
    // all lanes share the edges that have changed. few: skip the test whether these edges may
    // cross a silhouette at all.
    __device__ Around refresh(unsigned v, int column, int row, const Vec2f& p, bool few) const {
        const unsigned lane = query_.lane;
        const int u = lane < 6 ? step::neighbour_at(lattice_, column, row, static_cast<int>(lane)) : -1;
        const SnapVertex other = u >= 0 ? at(u) : SnapVertex{};
        const unsigned before = a_.seen[v];
        float share = lane < 6 && !(before & kFresh) ? a_.shares[v][lane] : -1;
        const unsigned on_silhouette = __ballot_sync(kAllLanes, other.on_silhouette());
        const unsigned stale = before & kFresh ? 63u : (before ^ on_silhouette) & 63u;
        const bool is_stale = stale >> lane & 1u;
        if (is_stale) share = -1;
        const unsigned crossing = __ballot_sync(
            kAllLanes, is_stale && u >= 0 && (few || step::may_cross(s_.tiles(), p, other.point())));
        if (crossing) {
            const unsigned size = 32 / __popc(crossing), group = lane / size;
            const int edge = static_cast<int>(__fns(crossing, 0, static_cast<int>(group) + 1));
            const Vec2f q = shuffle(other.point(), edge & 31);
            float t = -1;
            if (edge >= 0 && edge < 6)
                t = step::open_crossing(query_.part({group * size, size}), p, false, q,
                                        on_silhouette >> edge & 1u,
                                        edge < 3);  // neighbours with higher numbers come first
            __syncwarp();
            t = __shfl_sync(kAllLanes, t, size * __popc(crossing & ((1u << lane) - 1)) & 31);
            if (crossing >> lane & 1u) share = t;
        }
        if (is_stale) a_.shares[v][lane] = share;
        const auto nearest =
            step::nearest_crossing([&](int edge) { return __shfl_sync(kAllLanes, share, edge); });
        unsigned seen = before;
        if (stale) {
            const unsigned target = before >> kTargetShift;
            seen = on_silhouette;
            if (target && !(stale >> (target - 1) & 1u)) seen |= target << kTargetShift;
        }
        return {nearest.k, nearest.share, step::between(p, shuffle(other.point(), nearest.k), nearest.share),
                seen};
    }
    __device__ static Vec2f shuffle(const Vec2f& p, int from) {
        return {__shfl_sync(kAllLanes, p.x, from), __shfl_sync(kAllLanes, p.y, from)};
    }

    // One of the triangles around a vertex: eight lanes hold all of them, and each further eight
    // lanes hold them again.
    struct Corners {
        Vec2f at[3];
        int own;  // index of the vertex among them; -1: there is no triangle
    };
    __device__ Corners corners_around(unsigned v, int column, int row) const {
        Corners corners{{}, -1};
        Triangle t;
        if (!step::triangle_around(lattice_, column, row, static_cast<int>(query_.lane & 7u), t))
            return corners;
#pragma unroll
        for (int k = 0; k < 3; ++k) {
            corners.at[k] = at(t[k]).point();
            if (t[k] == v) corners.own = k;
        }
        return corners;
    }
    // Finds the first of two positions that the triangles allow: the first eight lanes try one, the next
    // eight the other, and the next eight measure the present position.
    __device__ bool find_place(const Corners& corners, const Vec2f& from, const Vec2f& first,
                               const Vec2f& second, Vec2f& to) const {
        const unsigned choice = query_.lane / 8;
        to = choice == 0 ? first : second;
        const bool may_move = step::keep_in_image(from, static_cast<float>(s_.sizes.width),
                                                  static_cast<float>(s_.sizes.height), to);
        const Vec2f p = choice < 2 ? to : from;
        float worst = 1;
        if (corners.own >= 0)
            worst = step::min_of(
                worst, step::shape(corners.own == 0 ? p : corners.at[0], corners.own == 1 ? p : corners.at[1],
                                   corners.own == 2 ? p : corners.at[2]));
        for (int by = 4; by > 0; by /= 2) worst = step::min_of(worst, __shfl_xor_sync(kAllLanes, worst, by));
        const float now = __shfl_sync(kAllLanes, worst, 16);
        const unsigned good =
            __ballot_sync(kAllLanes, may_move && (worst >= step::kLeastShape || worst >= now));
        const int chosen = good & 1u ? 0 : 8;
        to = shuffle(to, chosen);
        return good >> chosen & 1u;
    }

    const SurfaceState& s_;
    const SnapArrays& a_;
    WarpQuery query_;
    step::Lattice lattice_;
};

__global__ void __launch_bounds__(kGridThreads, 1)
    snap_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ SnapArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    DeviceSnapper(s, a, grid.lane()).run(grid);
}

}  // namespace

void snap_to_silhouettes(const Launch& launch, const SurfaceState& s, const SnapArrays& a) {
    launch_cooperative(launch, snap_kernel, 0, "snapping vertices", s, a);
}

}  // namespace hexrelief::cuda
