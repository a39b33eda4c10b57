// Lattice vertices move onto rims (mesher/align.h), as a part of the sheet's kernel.
#pragma once

#include <cstdint>

#include "cuda/sheet_look.cuh"
#include "cuda/sheet_state.cuh"
#include "mesher/steps/align.h"

namespace hexrelief::cuda {

// Read and written as a whole, so that who sees a vertex done sees where it went.
struct alignas(16) AlignVertex {
    float x, y;
    float share;    // of the way to the nearest crossing; below 0: none
    unsigned done;  // 2 * turns done + whether it lies on a rim

    __device__ bool on_rim() const { return done & 1u; }
    __device__ Vec2f place() const { return {x, y}; }
};

struct AlignArrays {
    AlignVertex* vertices;
    RimArrays rims;
    float (*shares)[6];   // of the edges to the neighbours
    Vec2f* targets;       // the rim's point nearest to a vertex
    std::uint16_t* seen;  // kFresh, kInVain, and bits of the neighbours that lay on rims when last seen
    std::uint32_t* candidates;
    unsigned* counts;  // of them, in each turn
};

template <typename Take>
AlignArrays take_align_arrays(const SheetSizes& sizes, const Take& take) {
    const std::size_t count = sizes.vertices();
    AlignArrays a;
    a.rims = take_rim_arrays(sizes, take);
    a.targets = take.template operator()<Vec2f>(count);
    a.vertices = take.template operator()<AlignVertex>(count);
    a.shares = reinterpret_cast<float(*)[6]>(take.template operator()<float>(6 * count));
    a.seen = take.template operator()<std::uint16_t>(count);
    a.candidates = take.template operator()<std::uint32_t>(count);
    a.counts = take.template operator()<unsigned>(step::kAlignTurns);
    return a;
}

// Vertices go as soon as their neighbours that come first have gone, without a barrier between them: a warp
// a vertex.
class DeviceAligner {
  public:
    __device__ DeviceAligner(const SheetState& s, const AlignArrays& a, unsigned lane)
        : s_(s), a_(a), look_(WarpLook::of(s, a.rims, lane)), lattice_{s.sizes.columns, s.sizes.rows} {}

    template <typename Crew>
    __device__ void run(const Crew& crew) const {
        if (crew.thread() < step::kAlignTurns) a_.counts[crew.thread()] = 0;
        if (crew.thread() == 0) *a_.rims.count = 0;
        crew.each(s_.sizes.vertices(), [&](unsigned v) {
            const Vec2f p = s_.lattice.points[v];
            a_.vertices[v] = {p.x, p.y, -1, 0};
            a_.seen[v] = kFresh;
            s_.lattice.on_rim[v] = 0;
        });
        find_rims(crew, s_, a_.rims);
        HEXRELIEF_ROLLED
        for (int turn = 0; turn < step::kAlignTurns; ++turn) {
            list_candidates(crew, turn);
            crew.wait();
            visit_all(crew, turn);
            crew.wait();
        }
    }

  private:
    // Bits of AlignArrays::seen: those of the neighbours, these, and 1 + the edge that the target is of.
    static constexpr unsigned kInVain = 64, kFresh = 128, kTargetShift = 8;

    __device__ AlignVertex at(unsigned v) const {
        unsigned x, y, share, done;
        asm volatile("ld.relaxed.gpu.global.v4.u32 {%0, %1, %2, %3}, [%4];"
                     : "=r"(x), "=r"(y), "=r"(share), "=r"(done)
                     : "l"(a_.vertices + v)
                     : "memory");
        return {__uint_as_float(x), __uint_as_float(y), __uint_as_float(share), done};
    }
    __device__ void put(unsigned v, const AlignVertex& vertex) const {
        asm volatile("st.relaxed.gpu.global.v4.u32 [%0], {%1, %2, %3, %4};" ::"l"(a_.vertices + v),
                     "r"(__float_as_uint(vertex.x)), "r"(__float_as_uint(vertex.y)),
                     "r"(__float_as_uint(vertex.share)), "r"(vertex.done)
                     : "memory");
    }
    __device__ int column(unsigned v) const { return static_cast<int>(v % s_.sizes.columns); }
    __device__ int row(unsigned v) const { return static_cast<int>(v / s_.sizes.columns); }
    __device__ static bool within(float share, int turn) {
        return share >= 0 && share <= step::align_reach(turn);
    }
    __device__ void list(unsigned v, int turn) const { a_.candidates[atomicAdd(a_.counts + turn, 1u)] = v; }

    template <typename Crew>
    __device__ void list_candidates(const Crew& crew, int turn) const {
        each_needed(
            crew, s_.sizes.vertices(), 32,
            [&](unsigned v) {
                if (v >= s_.sizes.vertices()) return false;
                const AlignVertex own = at(v);
                if (own.on_rim()) return false;
                if (needs_look(v, own)) return true;
                if (within(own.share, turn)) list(v, turn);
                return false;
            },
            [&](unsigned v, const LaneGroup&) {
                AlignVertex own = at(v);
                const Around around = refresh(v, own.place());
                own.share = around.share;
                const bool will_go = within(own.share, step::kAlignTurns - 1) && !around.has_target();
                const Vec2f target =
                    will_go ? step::nearest_rim(look_, own.place(), around.crossing) : Vec2f{};
                if (look_.lane != 0) return;
                if (will_go) {
                    a_.targets[v] = target;
                    a_.seen[v] = static_cast<std::uint16_t>(around.seen | around.edge_bits());
                }
                put(v, own);
                if (within(own.share, turn)) list(v, turn);
            });
    }
    // Whether a neighbour has come to a rim; at first, whether there is any around.
    __device__ bool needs_look(unsigned v, const AlignVertex& own) const {
        const int at_column = column(v), at_row = row(v);
        Vec2f lower = own.place(), upper = lower;
        unsigned on_rim = 0;
        const unsigned seen = a_.seen[v];
#pragma unroll
        for (int k = 0; k < 6; ++k) {
            const int u = step::neighbour_at(lattice_, at_column, at_row, k);
            if (u < 0) continue;
            const AlignVertex other = at(u);
            on_rim |= static_cast<unsigned>(other.on_rim()) << k;
            lower = {step::min_of(lower.x, other.x), step::min_of(lower.y, other.y)};
            upper = {step::max_of(upper.x, other.x), step::max_of(upper.y, other.y)};
        }
        if (!(seen & kFresh)) return on_rim != (seen & 63u);
        if (step::may_cross(s_.tiles(), lower, upper)) return true;
#pragma unroll
        for (int k = 0; k < 6; ++k) a_.shares[v][k] = -1;
        a_.seen[v] = static_cast<std::uint16_t>(on_rim);
        return false;
    }

    struct Around {
        int edge;        // with the least share
        float share;     // below 0: none
        Vec2f crossing;  // there
        unsigned seen;   // as AlignArrays::seen

        __device__ unsigned edge_bits() const { return static_cast<unsigned>(edge + 1) << kTargetShift; }
        __device__ bool has_target() const { return seen >> kTargetShift == edge_bits() >> kTargetShift; }
    };
    // What v, at p, meets on its ways to its neighbours: lane k knows about edge k, and as many lanes as
    // there are for each look at those that have changed.
    __device__ Around refresh(unsigned v, const Vec2f& p) const {
        const unsigned lane = look_.lane;
        const int u = lane < 6 ? step::neighbour_at(lattice_, column(v), row(v), static_cast<int>(lane)) : -1;
        const AlignVertex other = u >= 0 ? at(u) : AlignVertex{};
        const unsigned before = a_.seen[v];
        float share = lane < 6 && !(before & kFresh) ? a_.shares[v][lane] : -1;
        const unsigned on_rim = __ballot_sync(kWholeWarp, other.on_rim());
        const unsigned stale = before & kFresh ? 63u : (before ^ on_rim) & 63u;
        const bool is_stale = stale >> lane & 1u;
        if (is_stale) share = -1;
        const unsigned crossing =
            __ballot_sync(kWholeWarp, is_stale && u >= 0 && step::may_cross(s_.tiles(), p, other.place()));
        if (crossing) {
            const unsigned size = 32 / __popc(crossing), group = lane / size;
            const int edge = static_cast<int>(__fns(crossing, 0, static_cast<int>(group) + 1));
            const Vec2f q = shuffle(other.place(), edge & 31);
            float t = -1;
            if (edge >= 0 && edge < 6)
                t = step::open_crossing(look_.part({group * size, size}), p, false, q, on_rim >> edge & 1u);
            __syncwarp();
            t = __shfl_sync(kWholeWarp, t, size * __popc(crossing & ((1u << lane) - 1)) & 31);
            if (crossing >> lane & 1u) share = t;
        }
        if (is_stale) a_.shares[v][lane] = share;
        const auto nearest =
            step::nearest_crossing([&](int edge) { return __shfl_sync(kWholeWarp, share, edge); });
        unsigned seen = before;
        if (stale) {
            const unsigned target = before >> kTargetShift;
            seen = on_rim;
            if (target && !(stale >> (target - 1) & 1u)) seen |= target << kTargetShift;
            if (lane == 0) a_.seen[v] = static_cast<std::uint16_t>(seen);
        }
        return {nearest.k, nearest.share, step::between(p, shuffle(other.place(), nearest.k), nearest.share),
                seen};
    }
    __device__ static Vec2f shuffle(const Vec2f& p, int from) {
        return {__shfl_sync(kWholeWarp, p.x, from), __shfl_sync(kWholeWarp, p.y, from)};
    }

    // Each lane looks whether its own vertex may go, then the warp goes through those that may.
    template <typename Crew>
    __device__ void visit_all(const Crew& crew, int turn) const {
        const unsigned count = a_.counts[turn], warps = crew.threads() / 32;
        for (bool more = true; more;) {
            more = false;
            for (unsigned first = crew.thread() / 32; first < count; first += 32 * warps) {
                const unsigned i = first + look_.lane * warps, v = i < count ? a_.candidates[i] : 0;
                const State state = i < count ? state_of(v, turn) : kDone;
                more |= __any_sync(kWholeWarp, state == kWaits);
                for (unsigned going = __ballot_sync(kWholeWarp, state == kMayGo); going; going &= going - 1)
                    visit(__shfl_sync(kWholeWarp, v, __ffs(going) - 1), turn);
            }
        }
    }
    enum State { kDone, kWaits, kMayGo };
    __device__ State state_of(unsigned v, int turn) const {
        const unsigned done = 2u * turn + 2;
        const AlignVertex own = at(v);
        if (own.done >= done) return kDone;
        const int at_column = column(v), at_row = row(v);
        bool waits = false;
#pragma unroll
        for (int k = 0; k < 6; ++k) {
            const int u = step::neighbour_at(lattice_, at_column, at_row, k);
            if (u < 0) continue;
            const AlignVertex other = at(u);
            waits |= within(other.share, turn) && other.done < done &&
                     step::goes_before(other.share, u, own.share, v);
        }
        return waits ? kWaits : kMayGo;
    }
    __device__ void visit(unsigned v, int turn) const {
        AlignVertex own = at(v);
        const Vec2f from = own.place();
        const Corners corners = corners_around(v);
        const Vec2f target = a_.targets[v];
        const Around around = refresh(v, from);
        own.share = around.share;
        own.done = 2u * turn + 2;
        if (within(around.share, turn) && !(around.seen & kInVain)) {
            Vec2f to = around.has_target() ? target : step::nearest_rim(look_, from, around.crossing);
            bool moves = may_move(corners, from, to);
            if (!moves) {
                to = around.crossing;
                moves = may_move(corners, from, to);
            }
            if (moves) {
                own = {to.x, to.y, -1, own.done | 1u};
                if (look_.lane == 0) {
                    s_.lattice.points[v] = to;
                    s_.lattice.on_rim[v] = 1;
                }
            } else if (look_.lane == 0) {
                a_.seen[v] = static_cast<std::uint16_t>(around.seen | kInVain);
            }
        }
        if (look_.lane == 0) put(v, own);
    }

    // Of the triangle around a vertex that a lane sees to.
    struct Corners {
        Vec2f at[3];
        int own;  // which of them is the vertex; -1: there is no triangle
    };
    __device__ Corners corners_around(unsigned v) const {
        Corners corners{{}, -1};
        Triangle t;
        const int i = static_cast<int>(look_.lane);
        if (i >= 8 || !step::triangle_around(lattice_, column(v), row(v), i, t)) return corners;
#pragma unroll
        for (int k = 0; k < 3; ++k) {
            corners.at[k] = at(t[k]).place();
            if (t[k] == v) corners.own = k;
        }
        return corners;
    }
    __device__ bool may_move(const Corners& corners, const Vec2f& from, Vec2f& to) const {
        if (!step::keep_in_image(from, static_cast<float>(s_.sizes.width),
                                 static_cast<float>(s_.sizes.height), to))
            return false;
        const float after = worst_shape(corners, to);
        return after >= step::kLeastShape || after >= worst_shape(corners, from);
    }
    __device__ static float worst_shape(const Corners& corners, const Vec2f& p) {
        float worst = 1;
        if (corners.own >= 0)
            worst = step::min_of(
                worst, step::shape(corners.own == 0 ? p : corners.at[0], corners.own == 1 ? p : corners.at[1],
                                   corners.own == 2 ? p : corners.at[2]));
        for (int by = 4; by > 0; by /= 2) worst = step::min_of(worst, __shfl_xor_sync(kWholeWarp, worst, by));
        return __shfl_sync(kWholeWarp, worst, 0);
    }

    const SheetState& s_;
    const AlignArrays& a_;
    WarpLook look_;
    step::Lattice lattice_;
};

// Reads the lattice from s.lattice.points, and the pixels with their jumps; moves its vertices there and
// fills s.lattice.on_rim.
template <typename Crew>
__device__ void align_to_rims(Crew& crew, const SheetState& s, const AlignArrays& a) {
    DeviceAligner(s, a, crew.lane()).run(crew);
}

}  // namespace hexrelief::cuda
