// Which surface each triangle lies on, as SideFinder finds it.
#pragma once

#include <cstdint>

#include "cuda/sheet_crew.cuh"
#include "cuda/sheet_pieces.cuh"
#include "cuda/sheet_state.cuh"
#include "cuda/triangle_groups.cuh"
#include "cuda/triangle_warp.cuh"
#include "mesher/steps/triangle_sides.h"

namespace hexrelief::cuda {

// What is known from one update to the next.
struct SideArrays {
    struct Counts {
        unsigned known;      // triangles at the last update
        unsigned opened;     // whether edges were opened since
        unsigned listed;     // triangles on the list, to choose sides
        unsigned voting;     // and to vote
        unsigned pool_used;  // in this update
    };
    Counts* counts;
    std::uint32_t* places;      // a pixel: step::place_of() its triangle
    Vec2f (*corners)[3];        // a triangle: when its pixels were found
    std::uint8_t* states;       // a triangle: kPlain ...
    std::uint8_t* marks;        // a triangle: kToVote, kFresh
    std::uint32_t* row_counts;  // a triangle: rows with pixels
    unsigned* list;             // of triangles that take a whole warp
    unsigned* pool;             // for the pieces of huge triangles

    enum State : std::uint8_t { kPlain = 1, kTrusted = 2, kAny = 4 };  // no jump; no speck; pixels in it
    enum Mark : std::uint8_t { kToVote = 1, kFresh = 2 };
};

// Of a map's triangles, which hardly overlap.
__host__ __device__ inline unsigned pool_room(const SheetSizes& sizes) {
    return 2 * (sizes.pixels() + sizes.most_triangles);
}

template <typename Take>
SideArrays take_side_arrays(const SheetSizes& sizes, const Take& take) {
    SideArrays a{};
    a.counts = take.template operator()<SideArrays::Counts>(1);
    a.places = take.template operator()<std::uint32_t>(sizes.pixels());
    a.corners =
        reinterpret_cast<Vec2f(*)[3]>(take.template operator()<Vec2f>(3 * std::size_t{sizes.most_triangles}));
    a.states = take.template operator()<std::uint8_t>(sizes.most_triangles);
    a.marks = take.template operator()<std::uint8_t>(sizes.most_triangles);
    a.row_counts = take.template operator()<std::uint32_t>(sizes.most_triangles);
    a.list = take.template operator()<unsigned>(sizes.most_triangles);
    a.pool = take.template operator()<unsigned>(pool_room(sizes));
    return a;
}

// Puts those of the numbers of a warp's lanes that are wanted on a list.
__device__ inline void put_on_list(unsigned* list, unsigned& count, unsigned number, bool wanted) {
    const unsigned lane = threadIdx.x % 32, all = __ballot_sync(kAllLanes, wanted);
    if (all == 0) return;
    unsigned at = lane == 0 ? atomicAdd(&count, __popc(all)) : 0;
    at = __shfl_sync(kAllLanes, at, 0) + __popc(all & ((1u << lane) - 1));
    if (wanted) list[at] = number;
}

class DeviceSides {
  public:
    __device__ DeviceSides(const SheetState& s, const SideArrays& a) : s_(s), a_(a), view_(s.view()) {}

    template <typename Crew>
    __device__ void begin(Crew& crew) const {
        const unsigned pixels = s_.sizes.pixels();
        for (unsigned i = crew.thread(); i < pixels; i += crew.threads()) a_.places[i] = 0;
        if (crew.thread() == 0) *a_.counts = {0, 1, 0, 0, 0};
        crew.wait();
    }

    template <typename Crew>
    __device__ void update(Crew& crew) const {
        __shared__ unsigned busy;  // whether the room for large triangles is
        const unsigned count = s_.totals->triangles, known = a_.counts->known;
        const bool opened = a_.counts->opened != 0;
        each_wanted_by_group(
            crew, count,
            [&](unsigned t) {
                const std::uint8_t changed = s_.lattice.changed[t];
                if (t >= known) {
                    a_.marks[t] = SideArrays::kToVote | SideArrays::kFresh;
                    for (int k = 0; k < 3; ++k) s_.sides.open[t][k] = 0;
                    s_.lattice.changed[t] = kSame;
                    return false;
                }
                a_.marks[t] = opened ? 0 : a_.marks[t] & SideArrays::kToVote;
                return changed != kSame;
            },
            [&](unsigned t, bool has) { leave(t, has); });
        if (crew.thread() == 0) a_.counts->listed = a_.counts->voting = a_.counts->pool_used = 0;
        if (threadIdx.x == 0) busy = 0;
        crew.wait();
        each_wanted_by_group(
            crew, count, [&](unsigned t) { return (a_.marks[t] & SideArrays::kFresh) != 0; },
            [&](unsigned t, bool has) { look(t, has); });
        if (crew.thread() == 0) {
            a_.counts->known = count;
            a_.counts->opened = 0;
        }
        crew.wait();
        const unsigned listed = a_.counts->listed;
        for (unsigned i = crew.thread() / 32; i < listed; i += crew.threads() / 32)
            choose_side(crew.lane(), a_.list[i], busy);
        crew.wait();
    }

  private:
    enum Change : std::uint8_t { kSame, kMoved, kNew };  // as SplitLattice::Change

    __device__ TriangleRows rows_of(const Vec2f& p, const Vec2f& q, const Vec2f& r) const {
        return {view_.width, view_.height, p, q, r};
    }
    __device__ TriangleRows rows_of(unsigned t) const {
        const Triangle& v = s_.lattice.triangles[t];
        return rows_of(s_.lattice.points[v[0]], s_.lattice.points[v[1]], s_.lattice.points[v[2]]);
    }
    // Most triangles at rims move by so little that they keep their pixels, and with them all that follows.
    // Others leave theirs. By a group.
    __device__ void leave(unsigned t, bool has) const {
        const TriangleLanes group;
        const Vec2f* const old = a_.corners[t];
        const TriangleRows was = rows_of(old[0], old[1], old[2]), is = rows_of(t);
        bool same = s_.lattice.changed[t] == kMoved && (a_.states[t] & SideArrays::kAny) &&
                    was.first() == is.first() && was.end() == is.end();
        const int first = was.first() + static_cast<int>(group.lane);
        for (int y = first; has && same && y < was.end(); y += kGroup) same = was.run(y) == is.run(y);
        const bool differs = group.ballot(!same) != 0, leaves = has && differs;
        if (has && group.lane == 0) s_.lattice.changed[t] = kSame;
        if (!leaves) return;
        if (group.lane == 0) a_.marks[t] = SideArrays::kToVote | SideArrays::kFresh;
        for (int y = first; y < was.end(); y += kGroup) {
            const PixelRun run = was.run(y);
            std::uint32_t* const places = a_.places + view_.index(0, y);
            for (int x = run.first; x < run.end; ++x)
                if (step::belongs(places[x], t)) places[x] = 0;
        }
    }
    // Finds the triangle's pixels, and its side unless they may be of several pieces. By a group.
    __device__ void look(unsigned t, bool has) const {
        const TriangleLanes group;
        const Triangle& v = s_.lattice.triangles[t];
        const Vec2f p = s_.lattice.points[v[0]], q = s_.lattice.points[v[1]], r = s_.lattice.points[v[2]];
        unsigned row_count = 0;
        std::uint32_t first = 0;
        unsigned any = 0, all = step::kTrusted, inner = 0;  // flags; of jumps inside of the triangle
        bool apart = false;  // rows do not hang together, or around corners only
        each_row_by_group(rows_of(p, q, r), has, [&](const GroupRow& row) {
            const std::uint32_t begin =
                group.from(static_cast<std::uint32_t>(view_.index(row.run.first, row.run.y)),
                           row.all ? __ffs(static_cast<int>(row.all)) - 1 : 0);
            if (row_count == 0) first = begin;
            row_count += __popc(row.all);
            if (!row.own) return;
            const std::uint32_t start = static_cast<std::uint32_t>(view_.index(0, row.run.y));
            const auto of_eight = [&](int x, int end, std::uint32_t from, unsigned none, const auto& visit) {
                unsigned flags[8];  // at once, as long as they take to come
                HEXRELIEF_UNROLL
                for (int k = 0; k < 8; ++k) flags[k] = x + k < end ? view_.flags[from + x + k] : none;
                HEXRELIEF_UNROLL
                for (int k = 0; k < 8; ++k) visit(flags[k], x + k);
            };
            for (int x = row.run.first; x < row.run.end; x += 8)
                of_eight(x, row.run.end, start, step::kTrusted, [&](unsigned flags, int at) {
                    any |= flags;
                    all &= flags;
                    inner |= at + 1 < row.run.end ? flags & step::kJumpRight : 0;
                });
            for (int x = row.run.first; x < row.run.end; ++x)
                atomicMax(&a_.places[start + x], step::place_of(t, true));
            if (!row.has_upper) return;
            apart |= !step::lie_above(row.upper, row.run);
            if (apart) return;
            const int end = min(row.upper.end, row.run.end);
            for (int x = max(row.upper.first, row.run.first); x < end; x += 8)
                of_eight(x, end, start - view_.width, 0,
                         [&](unsigned flags, int) { inner |= flags & step::kJumpDown; });
        });
        const bool parted = group.ballot(apart || (any & (step::kJumpRight | step::kJumpDown))) != 0,
                   trusted = group.ballot(!all) == 0,
                   whole = group.ballot(apart || inner) == 0 || row_count == 0;
        put_on_list(a_.list, a_.counts->listed, t, has && group.lane == 0 && !whole);
        if (!has || group.lane > 2) return;
        a_.corners[t][group.lane] = group.lane == 0 ? p : group.lane == 1 ? q : r;
        if (group.lane != 0) return;
        a_.states[t] = (parted ? 0 : SideArrays::kPlain) | (trusted ? SideArrays::kTrusted : 0) |
                       (row_count > 0 ? SideArrays::kAny : 0);
        a_.row_counts[t] = row_count;
        if (whole) put_side(t, row_count > 0 ? first : step::middle_pixel(view_, p, q, r), false);
    }
    __device__ void put_side(unsigned t, std::uint32_t anchor, bool mixed) const {
        s_.sides.mixed[t] = mixed;
        s_.sides.anchors[t] = anchor;
        s_.sides.kept[t] = view_.disparity[anchor] > 0;
    }

    // Of several pieces. By a warp.
    __device__ void choose_side(unsigned lane, unsigned t, unsigned& busy) const {
        const Vec2f* const p = a_.corners[t];
        TriangleWarp pixels(view_, p[0], p[1], p[2]);
        unsigned count = 0;
        pixels.each_rows([&](const LaneRows& rows) { count = rows.end; });
        const unsigned share = SharedPieces::kOwn / (blockDim.x / 32);
        if (count <= SharedPieces::kLarge) {
            const bool large = count > share;
            if (large && lane == 0)
                while (atomicCAS(&busy, 0, 1) != 0) __nanosleep(100);
            __syncwarp();
            choose_side(t, pixels, count,
                        SharedPieces{large ? SharedPieces::kOwn : threadIdx.x / 32 * share});
            __threadfence_block();
            if (large && lane == 0) atomicExch(&busy, 0);
        } else {
            unsigned at = lane == 0 ? atomicAdd(&a_.counts->pool_used, 2 * count) : 0;
            at = __shfl_sync(kAllLanes, at, 0);
            const unsigned end = at + 2 * count, most = pool_room(s_.sizes);
            if (end <= most)
                choose_side(t, pixels, count, PooledPieces{a_.pool + at, a_.pool + at + count});
            else if (lane == 0)  // many triangles overlap
                atomicMax(&s_.totals->too_many, end - most);
        }
    }
    template <typename Room>
    __device__ void choose_side(unsigned t, TriangleWarp& pixels, unsigned count, const Room& room) const {
        WarpPieces<Room> pieces(view_, pixels, count, room);
        pieces.find();
        std::uint32_t anchor = ~0u;
        pixels.each_pixel([&](const LanePixel& pixel) {
            if (!pixel.valid) return;
            if (pixel.k == pieces.largest()) anchor = pixel.index;
            std::uint32_t& place = a_.places[pixel.index];
            if (!pieces.is_largest(pixel.k) && step::belongs(place, t)) place = step::place_of(t, false);
        });
        anchor = least_of_lanes(anchor);
        const bool mixed = count - pieces.area() >= step::kMixed_px &&
                           stray_error(pixels, pieces) > step::kMixedError_px2 * s_.settings.cell_px;
        if (threadIdx.x % 32 == 0) put_side(t, anchor, mixed);
        __syncwarp();
    }
    // Those of lanes that count, one after the other.
    __device__ static void add_in_order(double& sum, double value, bool counts) {
        const unsigned all = __ballot_sync(kAllLanes, counts);
        const double own = counts ? value : 0;  // which changes no sum
        for (unsigned first = 0; first < 32; first += 8)
            if (all >> first & 0xffu) {
                HEXRELIEF_UNROLL
                for (unsigned k = 0; k < 8; ++k) sum += __shfl_sync(kAllLanes, own, first + k);
            }
    }
    // Of the side's disparities, as if added one after the other.
    template <typename Pieces>
    __device__ double sum_of_side(TriangleWarp& pixels, const Pieces& pieces) const {
        double sum = 0;
        unsigned least = 255, most = 1;  // powers of 2, those of the smallest numbers as one
        pixels.each_pixel([&](const LanePixel& pixel) {
            if (!pixel.valid || !pieces.is_largest(pixel.k)) return;
            const float d = view_.disparity[pixel.index];
            const unsigned power = max(1u, __float_as_uint(d) >> 23 & 0xff);
            if (d != 0) least = min(least, power), most = max(most, power);
            sum += d;
        });
        least = least_of_lanes(least);
        most = most_of_lanes(most);
        // exact in any order: all are multiples of 2^(least - 23), their sum is below 2^(most + 1) times as
        // many
        if (most + 1 + (32 - __clz(pieces.area())) <= least - 23 + 53) {
            for (unsigned step = 16; step > 0; step /= 2) sum += __shfl_xor_sync(kAllLanes, sum, step);
            return sum;
        }
        sum = 0;
        pixels.each_pixel([&](const LanePixel& pixel) {
            const bool own = pixel.valid && pieces.is_largest(pixel.k);
            add_in_order(sum, own ? view_.disparity[pixel.index] : 0, own);
        });
        return sum;
    }
    // What the pixels of other pieces would cost if the side's mean stood for them.
    template <typename Pieces>
    __device__ double stray_error(TriangleWarp& pixels, const Pieces& pieces) const {
        const double mean = sum_of_side(pixels, pieces) / pieces.area(), nearest = s_.totals->nearest_px;
        double error = 0;
        pixels.each_pixel([&](const LanePixel& pixel) {
            const bool counts =
                pixel.valid && !pieces.is_largest(pixel.k) && (view_.flags[pixel.index] & step::kTrusted);
            add_in_order(error, counts ? step::stray_error(view_.disparity[pixel.index], mean, nearest) : 0,
                         counts);
        });
        return error;
    }
    const SheetState& s_;
    const SideArrays& a_;
    step::PixelView view_;
};

// Before the first update.
template <typename Crew>
__device__ void begin_sides(Crew& crew, const SheetState& s, const SideArrays& a) {
    DeviceSides(s, a).begin(crew);
}

// As SideFinder::update.
template <typename Crew>
__device__ void update_sides(Crew& crew, const SheetState& s, const SideArrays& a) {
    DeviceSides(s, a).update(crew);
}

}  // namespace hexrelief::cuda
