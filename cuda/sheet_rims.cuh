// Rim vertices fitted to the pixel sides with a jump, as mesher/fit_rims.cpp does.
#pragma once

#include "cuda/sheet_crew.cuh"
#include "cuda/sheet_state.cuh"
#include "mesher/steps/free_corners.h"
#include "mesher/steps/rim_fit.h"

namespace hexrelief::cuda {

struct RimEdge {
    unsigned a, b, key;       // vertices; 3 * triangle + corner, by which edges are summed
    unsigned a_slot, b_slot;  // among the edges at either vertex
};

struct RimSeen {
    float nx, ny;  // unit, to the left
    step::RimPulls pulls;
};

struct RimEnd {
    unsigned key, edge, which;  // which: 0 the edge's first vertex, 1 its second
};

// A triangle at a rim vertex.
struct RimCorner {
    Triangle vertices;
    unsigned key;  // 3 * triangle + corner
};

struct RimVertex {
    unsigned vertex, end_count, corner_count;
    unsigned first_end, first_corner;
};

struct RimTotals {
    unsigned edges, vertices, ends, corners;
};

struct RimFitArrays {
    RimTotals* totals;
    unsigned *end_counts, *corner_counts;  // of vertices
    unsigned *first_ends, *first_corners;  // of rim vertices, by vertex
    unsigned* corner_slots;                // 3 * triangle + corner: among the corners at its vertex
    RimEdge* edges;                        // in no order,
    RimVertex* vertices;                   // nor are these
    RimSeen* seen;                         // of edges
    RimEnd* ends;                          // at rim vertices
    RimCorner* corners;                    // at rim vertices
    Vec2f *targets, *points;               // of vertices; points: every other round's
    std::uint8_t* moved;                   // vertices: in the round before
};

template <typename Take>
RimFitArrays take_rim_fit_arrays(const SheetSizes& sizes, const Take& take) {
    const std::size_t points = sizes.most_points, corners = 3 * std::size_t{sizes.most_triangles};
    RimFitArrays a{};
    a.totals = take.template operator()<RimTotals>(1);
    for (unsigned** each : {&a.end_counts, &a.corner_counts, &a.first_ends, &a.first_corners})
        *each = take.template operator()<unsigned>(points);
    a.corner_slots = take.template operator()<unsigned>(corners);
    a.edges = take.template operator()<RimEdge>(corners / 2 + 1);  // each lies between two triangles
    a.vertices = take.template operator()<RimVertex>(points);
    a.seen = take.template operator()<RimSeen>(corners / 2 + 1);
    a.ends = take.template operator()<RimEnd>(corners + 2);
    a.corners = take.template operator()<RimCorner>(corners);
    for (Vec2f** each : {&a.targets, &a.points}) *each = take.template operator()<Vec2f>(points);
    a.moved = take.template operator()<std::uint8_t>(points);
    return a;
}

// The sum of count over the lanes before, and what total was before the warp; adds the warp's sum to it.
__device__ inline unsigned claim(unsigned* total, unsigned count) {
    const unsigned lane = threadIdx.x % 32;
    unsigned sum = count;
    for (unsigned step = 1; step < 32; step *= 2) {
        const unsigned other = __shfl_up_sync(~0u, sum, step);
        if (lane >= step) sum += other;
    }
    unsigned before = 0;
    if (lane == 31 && sum > 0) before = atomicAdd(total, sum);
    return __shfl_sync(~0u, before, 31) + sum - count;
}

// visit(item) for all, those with the least key first. There are few.
template <typename Item, typename Visit>
__device__ void in_order(const Item* items, unsigned count, const Visit& visit) {
    unsigned least = 0;
    for (unsigned k = 0; k < count; ++k) {
        unsigned next = ~0u, at = 0;
        for (unsigned i = 0; i < count; ++i) {
            const unsigned key = items[i].key;
            if (key >= least && key < next) next = key, at = i;
        }
        visit(items[at]);
        least = next + 1;
    }
}

// Whether the i-th of `count` vertices may move, i = thread / 8: asked by eight threads, who look at
// `corner_count` of its corners. All of a warp call it.
template <typename Corner>
__device__ bool is_free(const Corner* corners, unsigned corner_count, const Vec2f* points,
                        const Vec2f* targets, double least) {
    const unsigned lane = threadIdx.x % 32;
    bool free = true;
    for (unsigned c = lane % 8; c < corner_count; c += 8) {
        const auto corner = corners[c];
        const Triangle& t = corner.vertices;
        const Vec2f from[3] = {points[t[0]], points[t[1]], points[t[2]]};
        const Vec2f to[3] = {targets[t[0]], targets[t[1]], targets[t[2]]};
        free = free && (step::free_corners(from, to, least) >> corner.key % 3 & 1);
    }
    return (__ballot_sync(~0u, free) >> (lane & 24) & 0xff) == 0xff;
}

// What a warp sees of the pixel sides along an edge.
class EdgeWarp {
  public:
    __device__ EdgeWarp(const step::PixelView& view, const Vec2f& a, const Vec2f& b)
        : view_(view),
          frame_(step::rim_edge_frame(a, b)),
          box_(step::pixels_around(view, a, b, step::kRimFitReach_px)),
          width_(box_.x1 - box_.x0 + 1),
          per_width_(1 / static_cast<float>(width_)) {}

    __device__ RimSeen see() const {
        RimSeen seen{frame_.nx, frame_.ny, {}};
        if (!(frame_.size2 > 0)) return seen;
        double facing = 0;
        step::RimPull first{}, second{};  // of the first lists of 32; more are looked at again
        int lists = 0;
        each_32([&](const step::RimPull& pull) {
            if (lists == 0) first = pull;
            if (lists == 1) second = pull;
            ++lists;
            const float turned = pull.weight * pull.across;
            for (unsigned lanes = __ballot_sync(~0u, pull.weight != 0); lanes; lanes &= lanes - 1)
                facing += __shfl_sync(~0u, turned, __ffs(lanes) - 1);
        });
        const auto add = [&](const step::RimPull& pull) {
            const bool counts = pull.weight != 0 && pull.across * facing > 0;
            for (unsigned lanes = __ballot_sync(~0u, counts); lanes; lanes &= lanes - 1) {
                const int from = __ffs(lanes) - 1;
                step::add_pull(seen.pulls,
                               {__shfl_sync(~0u, pull.share, from), __shfl_sync(~0u, pull.residual, from),
                                __shfl_sync(~0u, pull.weight, from), __shfl_sync(~0u, pull.across, from)},
                               facing);
            }
        };
        if (lists > 2) {
            each_32(add);
        } else {
            if (lists > 0) add(first);
            if (lists > 1) add(second);
        }
        return seen;
    }

  private:
    static constexpr int kPixels = 128;  // looked at together

    // The pixel of the box, row by row.
    struct Place {
        int x, y;
    };
    __device__ Place place(int i) const {
        // exact for so few: the quotient is at least 0.5 / width from a whole number
        const int y = i < 65536 ? static_cast<int>((static_cast<float>(i) + 0.5f) * per_width_) : i / width_;
        return {box_.x0 + i - y * width_, box_.y0 + y};
    }
    __device__ static std::uint8_t* own_list() {
        __shared__ std::uint8_t lists[kMostCrewWarps][2 * kPixels];
        return lists[threadIdx.x / 32];
    }
    // visit(pull) with the pulls of up to 32 sides in the order of their pixels, one a lane.
    template <typename Visit>
    __device__ void each_32(const Visit& visit) const {
        std::uint8_t* const list = own_list();
        const int lane = static_cast<int>(threadIdx.x % 32);
        const int pixels = width_ * (box_.y1 - box_.y0 + 1);
        for (int start = 0; start < pixels; start += kPixels) {
            const int count = list_jumps(start, pixels, lane, list);
            for (int c = 0; c < count; c += 32) {
                step::RimPull pull{};
                if (c + lane < count) {
                    const int side = list[c + lane];
                    const Place at = place(start + side / 2);
                    pull = step::rim_pull(frame_, step::rim_side(view_, {at.x, at.y, side % 2}));
                }
                visit(pull);
            }
            __syncwarp();
        }
    }
    // Of kPixels pixels: 2 * (pixel - start), + 1 where the jump is downwards.
    __device__ int list_jumps(int start, int pixels, int lane, std::uint8_t* list) const {
        int flags[kPixels / 32];
#pragma unroll
        for (int k = 0; k < kPixels / 32; ++k) {
            const int i = start + 32 * k + lane;
            const Place at = place(i);
            flags[k] = i < pixels ? view_.flags[view_.index(at.x, at.y)] : 0;
        }
        const unsigned before = (1u << lane) - 1;
        int count = 0;
#pragma unroll
        for (int k = 0; k < kPixels / 32; ++k) {
            const bool right = flags[k] & step::kJumpRight, down = flags[k] & step::kJumpDown;
            const unsigned rights = __ballot_sync(~0u, right), downs = __ballot_sync(~0u, down);
            const int at = count + __popc(rights & before) + __popc(downs & before);
            const int side = 2 * (32 * k + lane);
            if (right) list[at] = static_cast<std::uint8_t>(side);
            if (down) list[at + right] = static_cast<std::uint8_t>(side + 1);
            count += __popc(rights) + __popc(downs);
        }
        __syncwarp();
        return count;
    }

    const step::PixelView& view_;
    step::RimEdgeFrame frame_;
    step::PixelBox box_;
    int width_;
    float per_width_;
};

// Rim edges, rim vertices, and what lies at them.
template <typename Crew>
__device__ void find_rim_edges(const Crew& crew, const SheetState& s, const RimFitArrays& a) {
    const unsigned points = s.totals->points, corners = 3 * s.totals->triangles;
    crew.each(points, [&](unsigned v) {
        a.end_counts[v] = a.corner_counts[v] = 0;
        if (v == 0) *a.totals = {};
    });
    crew.each(corners, [&](unsigned i) {
        const unsigned t = i / 3, k = i % 3, v = s.lattice.triangles[t][k];
        a.corner_slots[i] = atomicAdd(&a.corner_counts[v], 1);
        const std::int32_t n = s.lattice.neighbours[t][k];
        if (n < static_cast<std::int32_t>(t)) return;  // each once; none at the image's border
        if (!step::is_rim(s.sides.kept[t] != 0, s.sides.kept[n] != 0, s.sides.open[t][k] != 0)) return;
        const unsigned b = s.lattice.triangles[t][(k + 1) % 3];
        a.edges[atomicAdd(&a.totals->edges, 1)] = {v, b, i, atomicAdd(&a.end_counts[v], 1),
                                                   atomicAdd(&a.end_counts[b], 1)};
    });
    for (unsigned start = crew.thread() - crew.lane(); start < points; start += crew.threads()) {
        const unsigned v = start + crew.lane();
        const unsigned ends = v < points ? a.end_counts[v] : 0;
        const RimVertex rim{v, ends, ends > 0 ? a.corner_counts[v] : 0, claim(&a.totals->ends, ends),
                            claim(&a.totals->corners, ends > 0 ? a.corner_counts[v] : 0)};
        const unsigned at = claim(&a.totals->vertices, ends > 0);
        if (v >= points) continue;
        a.targets[v] = a.points[v] = s.lattice.points[v];
        if (ends == 0) continue;
        a.vertices[at] = rim;
        a.first_ends[v] = rim.first_end;
        a.first_corners[v] = rim.first_corner;
        a.moved[v] = 1;
    }
    crew.wait();
    for (unsigned e = crew.thread(); e < a.totals->edges; e += crew.threads()) {
        const RimEdge& edge = a.edges[e];
        a.ends[a.first_ends[edge.a] + edge.a_slot] = {edge.key, e, 0};
        a.ends[a.first_ends[edge.b] + edge.b_slot] = {edge.key, e, 1};
    }
    crew.each(corners, [&](unsigned i) {
        const Triangle& t = s.lattice.triangles[i / 3];
        const unsigned v = t[i % 3];
        if (a.end_counts[v] > 0) a.corners[a.first_corners[v] + a.corner_slots[i]] = {t, i};
    });
}

// Moves s.lattice.points and marks s.lattice.changed; reads s.pixels, s.sides.kept and s.sides.open.
template <typename Crew>
__device__ void fit_rims(const Crew& crew, const SheetState& s, const RimFitArrays& a) {
    constexpr std::uint8_t kSame = 0, kMoved = 1;  // as SplitLattice::Change
    find_rim_edges(crew, s, a);
    const step::PixelView view = s.view();
    const float width = static_cast<float>(view.width), height = static_cast<float>(view.height);
    const unsigned edges = a.totals->edges, vertices = a.totals->vertices;
    if (edges == 0) return;
    Vec2f *points = a.points, *next = s.lattice.points;  // the last round writes there
    static_assert(step::kRimRounds % 2 == 1);
#pragma unroll 1
    for (int round = 0; round < step::kRimRounds; ++round) {
        crew.each_by_warp(edges, [&](unsigned e, unsigned lane) {
            const unsigned v = a.edges[e].a, w = a.edges[e].b;
            if (!a.moved[v] && !a.moved[w]) return;
            const RimSeen seen = EdgeWarp(view, points[v], points[w]).see();
            if (lane == 0) a.seen[e] = seen;
        });
        crew.each(vertices, [&](unsigned i) {
            const RimVertex rim = a.vertices[i];
            step::RimEquation equation;
            in_order(a.ends + rim.first_end, rim.end_count, [&](const RimEnd& end) {
                const RimSeen& seen = a.seen[end.edge];
                step::add_edge(equation, seen.nx, seen.ny, seen.pulls.weights[end.which],
                               seen.pulls.residuals[end.which]);
            });
            a.targets[rim.vertex] = step::rim_target(equation, points[rim.vertex], width, height);
        });
        for (unsigned start = crew.thread() / 32 * 4; start < vertices; start += crew.threads() / 32 * 4) {
            const unsigned i = start + crew.lane() / 8;
            const RimVertex rim = i < vertices ? a.vertices[i] : RimVertex{};
            const Vec2f from = points[rim.vertex], to = a.targets[rim.vertex];
            const bool wants = i < vertices && !(from == to);
            const bool moves = is_free(a.corners + rim.first_corner, wants ? rim.corner_count : 0, points,
                                       a.targets, step::kRimLeastShape) &&
                               wants;
            if (i >= vertices) continue;
            if (crew.lane() % 8 == 0) {
                next[rim.vertex] = moves ? to : from;
                a.moved[rim.vertex] = moves;
            }
            for (unsigned c = crew.lane() % 8; moves && c < rim.corner_count; c += 8) {
                std::uint8_t& changed = s.lattice.changed[a.corners[rim.first_corner + c].key / 3];
                if (changed == kSame) changed = kMoved;
            }
        }
        crew.wait();
        Vec2f* const last = points;
        points = next;
        next = last;
    }
}

}  // namespace hexrelief::cuda
