// Which surface each triangle lies on, as SideFinder finds it.
#pragma once

#include <cstdint>

#include "cuda/sheet_crew.cuh"
#include "cuda/sheet_pieces.cuh"
#include "cuda/sheet_state.cuh"
#include "cuda/triangle_warp.cuh"
#include "mesher/steps/triangle_sides.h"

namespace hexrelief::cuda {

// What is known from one update to the next.
struct SideArrays {
    struct Counts {
        unsigned known;      // triangles at the last update
        unsigned opened;     // whether edges were opened since
        unsigned pool_used;  // in this update
    };
    Counts* counts;
    std::uint32_t* places;      // a pixel: step::place_of() its triangle
    Vec2f (*corners)[3];        // a triangle: when its pixels were found
    std::uint8_t* states;       // a triangle: kPlain ...
    std::uint8_t* marks;        // a triangle: kToVote, kFresh
    std::uint32_t* row_counts;  // a triangle: rows with pixels
    unsigned* pool;             // for the pieces of large triangles

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
    a.pool = take.template operator()<unsigned>(pool_room(sizes));
    return a;
}

class DeviceSides {
  public:
    __device__ DeviceSides(const SheetState& s, const SideArrays& a) : s_(s), a_(a), view_(s.view()) {}

    template <typename Crew>
    __device__ void begin(Crew& crew) const {
        const unsigned pixels = s_.sizes.pixels();
        for (unsigned i = crew.thread(); i < pixels; i += crew.threads()) a_.places[i] = 0;
        if (crew.thread() == 0) *a_.counts = {0, 1, 0};
        crew.wait();
    }

    template <typename Crew>
    __device__ void update(Crew& crew) const {
        const unsigned count = s_.totals->triangles, known = a_.counts->known;
        const bool opened = a_.counts->opened != 0;
        each_wanted(
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
            [&](unsigned t) { leave(crew.lane(), t); });
        if (crew.thread() == 0) a_.counts->pool_used = 0;
        crew.wait();
        each_wanted(
            crew, count, [&](unsigned t) { return (a_.marks[t] & SideArrays::kFresh) != 0; },
            [&](unsigned t) { look(crew.lane(), t); });
        if (crew.thread() == 0) {
            a_.counts->known = count;
            a_.counts->opened = 0;
        }
        crew.wait();
    }

    template <typename Crew>
    __device__ void open_edges(Crew& crew) const {
        const unsigned count = s_.totals->triangles;
        each_wanted(
            crew, count,
            [&](unsigned t) {
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
            },
            [&](unsigned t) { vote(crew.lane(), t); });
        if (crew.thread() == 0) a_.counts->opened = 1;
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
    enum Change : std::uint8_t { kSame, kMoved, kNew };  // as SplitLattice::Change

    __device__ bool is_plain(unsigned t) const {
        constexpr std::uint8_t kBoth = SideArrays::kPlain | SideArrays::kAny;
        return (a_.states[t] & kBoth) == kBoth;
    }
    // Most triangles at rims move by so little that they keep their pixels, and with them all that follows.
    // Others leave theirs.
    __device__ void leave(unsigned lane, unsigned t) const {
        const Vec2f* const old = a_.corners[t];
        const Vec2f p = old[0], q = old[1], r = old[2];
        const bool moved = s_.lattice.changed[t] == kMoved && (a_.states[t] & SideArrays::kAny);
        __syncwarp();
        if (lane == 0) s_.lattice.changed[t] = kSame;
        if (moved) {
            const Triangle& v = s_.lattice.triangles[t];
            const Vec2f* const points = s_.lattice.points;
            const TriangleRows was(view_.width, view_.height, p, q, r),
                is(view_.width, view_.height, points[v[0]], points[v[1]], points[v[2]]);
            bool same = was.first() == is.first() && was.end() == is.end();
            for (int y = was.first() + static_cast<int>(lane); same && y < was.end(); y += 32)
                same = was.run(y) == is.run(y);
            if (__all_sync(kAllLanes, same)) return;
        }
        if (lane == 0) a_.marks[t] = SideArrays::kToVote | SideArrays::kFresh;
        TriangleWarp(view_, p, q, r).each_pixel([&](const LanePixel& pixel) {
            if (pixel.valid && step::belongs(a_.places[pixel.index], t)) a_.places[pixel.index] = 0;
        });
    }
    // Finds the triangle's pixels and its side.
    __device__ void look(unsigned lane, unsigned t) const {
        const Triangle& v = s_.lattice.triangles[t];
        const Vec2f p = s_.lattice.points[v[0]], q = s_.lattice.points[v[1]], r = s_.lattice.points[v[2]];
        TriangleWarp pixels(view_, p, q, r);
        unsigned count = 0, row_count = 0;
        std::uint32_t first = ~0u;
        bool parted = false, trusted = true;  // parted: by a jump, or around corners
        pixels.each_rows([&](const LaneRows& rows) {
            const unsigned own = __ballot_sync(kAllLanes, rows.own);
            if (own == 0) return;
            if (rows.own && rows.has_upper) parted |= !step::lie_above(rows.upper, rows.run);
            row_count += __popc(own);
            count = rows.end;
            if (first == ~0u)
                first = __shfl_sync(kAllLanes,
                                    static_cast<std::uint32_t>(view_.index(rows.run.first, rows.run.y)),
                                    __ffs(static_cast<int>(own)) - 1);
            pixels.each_pixel(rows, [&](const LanePixel& pixel) {
                if (!pixel.valid) return;
                const std::uint8_t flags = view_.flags[pixel.index];
                parted |= (flags & (step::kJumpRight | step::kJumpDown)) != 0;
                trusted &= (flags & step::kTrusted) != 0;
            });
        });
        parted = __any_sync(kAllLanes, parted);
        trusted = __all_sync(kAllLanes, trusted);
        bool mixed = false;
        if (parted && count > 0)
            mixed = choose_side(lane, t, pixels, count, first);
        else
            claim(t, pixels, [](const LanePixel&) { return true; });
        if (lane < 3) a_.corners[t][lane] = lane == 0 ? p : lane == 1 ? q : r;
        if (lane != 0) return;
        a_.states[t] = (parted ? 0 : SideArrays::kPlain) | (trusted ? SideArrays::kTrusted : 0) |
                       (count > 0 ? SideArrays::kAny : 0);
        a_.row_counts[t] = row_count;
        const std::uint32_t anchor = count > 0 ? first : step::middle_pixel(view_, p, q, r);
        s_.sides.mixed[t] = mixed;
        s_.sides.anchors[t] = anchor;
        s_.sides.kept[t] = view_.disparity[anchor] > 0;
    }
    template <typename IsOnSide>
    __device__ void claim(unsigned t, TriangleWarp& pixels, const IsOnSide& is_on_side) const {
        pixels.each_pixel([&](const LanePixel& pixel) {
            if (pixel.valid) atomicMax(&a_.places[pixel.index], step::place_of(t, is_on_side(pixel)));
        });
    }
    // The largest piece; first becomes its first pixel. Returns whether the triangle is mixed.
    __device__ bool choose_side(unsigned lane, unsigned t, TriangleWarp& pixels, unsigned count,
                                std::uint32_t& first) const {
        constexpr unsigned kShared = 3072;
        __shared__ unsigned shared[kShared];
        const unsigned share = kShared / (blockDim.x / 32);
        unsigned* room = shared + threadIdx.x / 32 * share;
        if (2 * count > share) {
            unsigned at = lane == 0 ? atomicAdd(&a_.counts->pool_used, 2 * count) : 0;
            at = __shfl_sync(kAllLanes, at, 0);
            const unsigned end = at + 2 * count, most = pool_room(s_.sizes);
            if (end > most) {
                if (lane == 0) atomicMax(&s_.totals->too_many, end - most);
                return false;
            }
            room = a_.pool + at;
        }
        WarpPieces pieces(view_, pixels, count, room);
        pieces.find();
        std::uint32_t found = ~0u;
        claim(t, pixels, [&](const LanePixel& pixel) {
            if (pixel.k == pieces.largest()) found = pixel.index;
            return pieces.is_largest(pixel.k);
        });
        first = __reduce_min_sync(kAllLanes, found);
        const bool mixed = count - pieces.area() >= step::kMixed_px &&
                           stray_error(pixels, pieces) > step::kMixedError_px2 * s_.settings.cell_px;
        __syncwarp();
        return mixed;
    }
    // What the pixels of other pieces would cost if the side's mean stood for them. Added up in the pixels'
    // order.
    __device__ double stray_error(TriangleWarp& pixels, const WarpPieces& pieces) const {
        double sum = 0, error = 0;
        pixels.each_pixel([&](const LanePixel& pixel) {
            const bool own = pixel.valid && pieces.is_largest(pixel.k);
            const float d = own ? view_.disparity[pixel.index] : 0;
            for (unsigned left = __ballot_sync(kAllLanes, own); left != 0; left &= left - 1)
                sum += __shfl_sync(kAllLanes, d, __ffs(static_cast<int>(left)) - 1);
        });
        const double mean = sum / pieces.area(), nearest = s_.totals->nearest_px;
        pixels.each_pixel([&](const LanePixel& pixel) {
            const bool counts =
                pixel.valid && !pieces.is_largest(pixel.k) && (view_.flags[pixel.index] & step::kTrusted);
            const double e = counts ? step::stray_error(view_.disparity[pixel.index], mean, nearest) : 0;
            for (unsigned left = __ballot_sync(kAllLanes, counts); left != 0; left &= left - 1)
                error += __shfl_sync(kAllLanes, e, __ffs(static_cast<int>(left)) - 1);
        });
        return error;
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
            const int all = __reduce_add_sync(kAllLanes, pairs[k]),
                      sum = __reduce_add_sync(kAllLanes, votes[k]);
            bool open = false;
            if (around[k] >= 0) open = all > 0 ? sum > 0 : differ(lane, t, static_cast<unsigned>(around[k]));
            if (lane == 0) s_.sides.open[t][k] = open;
        }
    }

    const SheetState& s_;
    const SideArrays& a_;
    step::PixelView view_;
};

// Before the first update; a barrier must follow.
template <typename Crew>
__device__ void begin_sides(Crew& crew, const SheetState& s, const SideArrays& a) {
    DeviceSides(s, a).begin(crew);
}

// As SideFinder::update.
template <typename Crew>
__device__ void update_sides(Crew& crew, const SheetState& s, const SideArrays& a) {
    DeviceSides(s, a).update(crew);
}

// As SideFinder::open_edges.
template <typename Crew>
__device__ void open_edges(Crew& crew, const SheetState& s, const SideArrays& a) {
    DeviceSides(s, a).open_edges(crew);
}

}  // namespace hexrelief::cuda
