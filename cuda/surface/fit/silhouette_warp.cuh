// One warp's part of the silhouettes' fit.
#pragma once

#include "cuda/common/relaxed.cuh"
#include "cuda/surface/fit/silhouette_edges.cuh"
#include "cuda/surface/fit/silhouette_lists.cuh"
#include "cuda/surface/fit/silhouette_samples.cuh"
#include "mesher/surface/fit/fit_disparities_step.h"
#include "mesher/surface/topology/split_lattice_step.h"
#include "mesher/surface/topology/triangle_shape_step.h"

namespace hexrelief::cuda {

// A few silhouette vertices, which a warp moves through all rounds. There is no barrier: each vertex waits
// only for its neighbours, which publish their positions and targets. Lane e holds the e-th end of an edge at
// one of the vertices, lane i the i-th vertex; each edge is summed up from both of its ends.
class SilhouetteWarp {
  public:
    static constexpr unsigned kVertices = 4;

    __device__ SilhouetteWarp(const SurfaceState& s, const SilhouetteFitArrays& a, uint4* words,
                              const SilhouetteLists<SilhouetteEnd>& end_lists,
                              const SilhouetteLists<unsigned>& corner_lists, SilhouetteScratch& scratch)
        : s_(s),
          a_(a),
          end_lists_(end_lists),
          corner_lists_(corner_lists),
          scratch_(scratch),
          view_(s.view()),
          samples_(view_, words, scratch),
          lane_(threadIdx.x % 32) {}

    // Takes `count` vertices of a.vertices, `stride` apart from `first` on, for a round; after: their targets
    // have already been found in this round.
    __device__ void begin(unsigned first, unsigned stride, unsigned count, int round, bool after) {
        vertices_ = count;
        const bool is_one = lane_ < count;
        v_ = is_one ? a_.vertices[first + lane_ * stride] : 0;
        end_count_ = is_one ? a_.end_counts[v_] : 0;
        corner_count_ = is_one ? a_.corner_counts[v_] : 0;
        at_ = !is_one ? Vec2f{} : round == 0 ? s_.lattice.points[v_] : point_after(a_, v_, round - 1);
        to_ = is_one && after ? move_of(v_, round).to : at_;
        first_end_ = first_corner_ = 0;
        ends_ = 0;
#pragma unroll
        for (unsigned i = 0; i < kVertices; ++i) {
            if (lane_ == i) first_end_ = ends_;
            ends_ += __shfl_sync(~0u, end_count_, i);
        }
        unsigned corners = 0;
#pragma unroll
        for (unsigned i = 0; i < kVertices; ++i) {
            if (lane_ == i) first_corner_ = corners;
            corners += __shfl_sync(~0u, corner_count_, i);
        }
        corners_ = corners;
        fits_ = ends_ <= 32;
        marked_ = false;
        unsigned owner;  // loaded first, used last
        const unsigned key = key_at(lane_, owner);
        const SilhouetteEnd end = end_at(lane_);
        corner_ = corner_of(key, owner);
        if (fits_) sort_ends(end);
    }
    // Finds and publishes the vertices' targets. fresh: there are no data from the preceding round.
    __device__ void find_targets(int round, bool fresh) {
        if (fits_) {
            const bool active = follow_ends(round) || fresh;
            const unsigned actives = __ballot_sync(~0u, active && lane_ < ends_);
            if (actives) {
                if (fresh || samples_.have_left(ends_, a_at_, b_at_))
                    fits_ = samples_.find(ends_, a_at_, b_at_);
                fits_ = fits_ && samples_.see(actives, ends_, a_at_, b_at_, other_ & 1u, seen_);
                if (fits_) solve(actives);
            }
        }
        if (!fits_) {
            HEXRELIEF_ROLLED
            for (unsigned i = 0; i < vertices_; ++i) {
                const unsigned v = __shfl_sync(~0u, v_, i), count = __shfl_sync(~0u, end_count_, i);
                const Vec2f to = target_alone(s_, a_, end_lists_.first(v), count, shuffle(at_, i), round);
                if (lane_ == i) to_ = to;
            }
        }
        if (lane_ < vertices_) put_move(v_, round);
    }
    // Moves the vertices, unless triangles hold them back.
    __device__ void move(int round) {
        const bool wants = lane_ < vertices_ && !(to_ == at_);
        const unsigned wanting = __ballot_sync(~0u, wants);
        unsigned held = 0;
        if (wanting)
            each_corner([&](const SilhouetteCorner& corner, bool is_one) {
                const Vec2f from = shuffle(at_, corner.owner), to = shuffle(to_, corner.owner);
                const bool asked = is_one && (wanting >> corner.owner & 1u);
                const bool holds = asked && !is_free(corner, {to, from}, round);
#pragma unroll
                for (unsigned i = 0; i < kVertices; ++i)
                    held |= static_cast<unsigned>(__any_sync(~0u, holds && corner.owner == i)) << i;
            });
        const bool moves = wants && !(held >> lane_ & 1u);
        const Vec2f next = moves ? to_ : at_;
        if (lane_ < vertices_) {
            if (round + 1 < step::kSilhouetteRounds)
                put_point(v_, round, next);
            else
                s_.lattice.points[v_] = next;
        }
        const unsigned fresh = __ballot_sync(~0u, moves && !marked_);
        if (fresh) mark(fresh);
        marked_ |= moves;
        at_ = next;
    }
    // Marks a vertex's moves and positions as not yet known.
    __device__ static void clear(const SilhouetteFitArrays& a, unsigned v) {
        const Vec2f missing{__uint_as_float(kNotYet), 0};
        for (int k = 0; k < step::kSilhouetteRounds; ++k)
            a.moves[step::kSilhouetteRounds * v + k] = {missing, {0, 0}};
        for (int k = 0; k < step::kSilhouetteRounds - 1; ++k)
            a.points[(step::kSilhouetteRounds - 1) * v + k] = missing;
    }

  private:
    static constexpr unsigned kNotYet = 0xffffffffu;  // not a coordinate: no arithmetic produces these bits

    // A triangle at one of the vertices.
    struct SilhouetteCorner {
        unsigned owner, triangle, k;  // k: corner of the triangle
        unsigned others[2];           // the other vertices of the triangle
        bool on_silhouette[2];
        Vec2f own, origins[2];  // start positions of the vertices; those not on silhouettes stay there
        float slack2;           // px2: while no vertex is farther from its start, they may move in any way
    };

    __device__ static Vec2f shuffle(const Vec2f& p, unsigned from) {
        return {__shfl_sync(~0u, p.x, from), __shfl_sync(~0u, p.y, from)};
    }
    // Replaces coordinates that equal kNotYet.
    __device__ static Vec2f known(const Vec2f& p) {
        return {__float_as_uint(p.x) == kNotYet ? __uint_as_float(kNotYet >> 1) : p.x, p.y};
    }
    __device__ void put_move(unsigned v, int round) const {
        store_relaxed(&a_.moves[step::kSilhouetteRounds * v + round], {known(to_), at_});
    }
    __device__ SilhouetteMove move_of(unsigned v, int round) const {
        return load_relaxed(&a_.moves[step::kSilhouetteRounds * v + round]);
    }
    __device__ void put_point(unsigned v, int round, const Vec2f& p) const {
        store_relaxed(&a_.points[(step::kSilhouetteRounds - 1) * v + round], known(p));
    }
    __device__ static Vec2f point_after(const SilhouetteFitArrays& a, unsigned v, int round) {
        return load_relaxed(&a.points[(step::kSilhouetteRounds - 1) * v + round]);
    }
    __device__ static bool is_missing(const Vec2f& p) {
        return __float_as_uint(p.x) == kNotYet;
    }
    __device__ static Vec2f wait_for_point(const SurfaceState& s, const SilhouetteFitArrays& a, unsigned v,
                                           int round) {
        if (round == 0) return s.lattice.points[v];
        Vec2f p = point_after(a, v, round - 1);
        while (is_missing(p)) p = point_after(a, v, round - 1);
        return p;
    }

    // Returns the vertex to which an item belongs, in a list of the items of all vertices.
    __device__ unsigned owner_of(unsigned first_of_own, unsigned item) const {
        unsigned owner = 0;
#pragma unroll
        for (unsigned i = 1; i < kVertices; ++i) {
            const unsigned first = __shfl_sync(~0u, first_of_own, i);
            owner += i < vertices_ && item >= first;
        }
        return owner;
    }
    __device__ unsigned key_at(unsigned corner, unsigned& owner) const {
        owner = owner_of(first_corner_, corner);
        const unsigned v = __shfl_sync(~0u, v_, owner),
                       place = corner - __shfl_sync(~0u, first_corner_, owner);
        return corner < corners_ ? a_.corners[corner_lists_.first(v) + place] : 0;
    }
    __device__ SilhouetteCorner corner_of(unsigned key, unsigned owner) const {
        SilhouetteCorner corner{owner, key / 3, key % 3, {}, {}, {}, {}, 0};
        const Triangle t = s_.lattice.triangles[corner.triangle];
        corner.others[0] = corner.k == 0 ? t[1] : corner.k == 1 ? t[2] : t[0];
        corner.others[1] = corner.k == 0 ? t[2] : corner.k == 1 ? t[0] : t[1];
#pragma unroll
        for (unsigned k = 0; k < 2; ++k) {
            corner.on_silhouette[k] = a_.end_counts[corner.others[k]] > 0;
            corner.origins[k] = s_.lattice.points[corner.others[k]];
        }
        corner.own = shuffle(at_, owner);
        corner.slack2 = step::corner_slack2(corner.own, corner.origins[0], corner.origins[1],
                                            step::kSilhouetteLeastShape);
        return corner;
    }
    // Calls visit(corner, whether there is one) for all corners, one per lane.
    template <typename Visit>
    __device__ void each_corner(const Visit& visit) const {
        SilhouetteCorner corner = corner_;
        HEXRELIEF_ROLLED
        for (unsigned first = 0; first < corners_; first += 32) {
            if (first > 0) {
                unsigned owner;
                const unsigned key = key_at(first + lane_, owner);
                corner = corner_of(key, owner);
            }
            visit(corner, first + lane_ < corners_);
        }
    }
    __device__ SilhouetteEnd end_at(unsigned item) {
        owner_ = owner_of(first_end_, item);
        const unsigned v = __shfl_sync(~0u, v_, owner_), place = item - __shfl_sync(~0u, first_end_, owner_);
        return item < ends_ ? a_.ends[end_lists_.first(v) + place] : SilhouetteEnd{};
    }
    __device__ void sort_ends(const SilhouetteEnd& end) {
        const unsigned first = __shfl_sync(~0u, first_end_, owner_);
        unsigned place = first;
        HEXRELIEF_ROLLED
        for (unsigned e = 0; e < ends_; ++e) {
            const unsigned key = __shfl_sync(~0u, end.key, e), owner = __shfl_sync(~0u, owner_, e);
            place += owner == owner_ && key < end.key;
        }
        unsigned* const sorted = scratch_.words;
        if (lane_ < ends_) sorted[place] = end.other;
        __syncwarp();
        other_ = lane_ < ends_ ? sorted[lane_] : 0;
        __syncwarp();
    }
    // Reads the present positions of the edges' vertices; returns true if the lane's edge has moved.
    __device__ bool follow_ends(int round) {
        const Vec2f mine = shuffle(at_, owner_);
        if (lane_ >= ends_) return false;
        const Vec2f others = wait_for_point(s_, a_, other_ / 2, round);
        const bool second = other_ & 1u;
        const Vec2f a = second ? others : mine, b = second ? mine : others;
        const bool moved = !(a == a_at_) || !(b == b_at_);
        a_at_ = a;
        b_at_ = b;
        return moved;
    }
    __device__ void solve(unsigned actives) {
        step::SilhouetteEquation equation;
        HEXRELIEF_ROLLED
        for (unsigned k = 0; __any_sync(~0u, k < end_count_); ++k) {
            const unsigned e = first_end_ + k & 31u;
            const float nx = __shfl_sync(~0u, seen_.nx, e), ny = __shfl_sync(~0u, seen_.ny, e);
            const double weight = __shfl_sync(~0u, seen_.weight, e),
                         residual = __shfl_sync(~0u, seen_.residual, e);
            if (k < end_count_) step::add_edge(equation, nx, ny, weight, residual);
        }
        // bits of the vertex's own ends
        const unsigned own = end_count_ > 0 ? ~0u >> (32 - end_count_) << first_end_ : 0;
        if (lane_ < vertices_ && (actives & own)) to_ = target(view_, equation, at_);
    }
    __device__ static Vec2f target(const step::PixelView& view, const step::SilhouetteEquation& equation,
                                   const Vec2f& from) {
        return step::silhouette_target(equation, from, static_cast<float>(view.width),
                                       static_cast<float>(view.height));
    }
    // Returns a vertex's target, edge by edge: for vertices with more edges or samples than the capacity.
    // By the whole warp.
    __device__ static __noinline__ Vec2f target_alone(const SurfaceState& s, const SilhouetteFitArrays& a,
                                                      unsigned first_end, unsigned count, const Vec2f at,
                                                      int round) {
        const step::PixelView view = s.view();
        step::SilhouetteEquation equation;
        in_order(
            a.ends + first_end, count, [](const SilhouetteEnd& end) { return end.key; },
            [&](const SilhouetteEnd& end) {
                const Vec2f other = wait_for_point(s, a, end.other / 2, round);
                const unsigned which = end.other & 1u;
                const Vec2f p = which ? other : at, q = which ? at : other;
                const step::SilhouetteEdgeFrame frame = step::silhouette_edge_frame(p, q);
                const step::SilhouetteResiduals pulls =
                    EdgeWarp(view, p, q, step::kSilhouetteFitReach_px).see(p, q);
                step::add_edge(equation, frame.nx, frame.ny, pulls.weights[which], pulls.residuals[which]);
            });
        return target(view, equation, at);
    }

    __device__ static float farthest2(const SilhouetteMove& move, const Vec2f& from) {
        return step::max_of(step::squared_length(move.from, from), step::squared_length(move.to, from));
    }
    // True if this triangle allows its owner to move.
    __device__ bool is_free(const SilhouetteCorner& corner, const SilhouetteMove& own, int round) const {
        SilhouetteMove others[2];
        bool missing;
        do {  // both loads before the first use
            missing = false;
#pragma unroll
            for (int k = 0; k < 2; ++k) {
                others[k] = corner.on_silhouette[k] ? move_of(corner.others[k], round)
                                                    : SilhouetteMove{corner.origins[k], corner.origins[k]};
                missing |= corner.on_silhouette[k] && is_missing(others[k].to);
            }
        } while (missing);
        const SilhouetteMove &next = others[0], &last = others[1];
        if (step::max_of(farthest2(own, corner.own), step::max_of(farthest2(next, corner.origins[0]),
                                                                  farthest2(last, corner.origins[1]))) <=
            corner.slack2)
            return true;
        const SilhouetteMove &first = corner.k == 0   ? own
                                      : corner.k == 1 ? last
                                                      : next,
                             &second = corner.k == 1   ? own
                                       : corner.k == 2 ? last
                                                       : next,
                             &third = corner.k == 2   ? own
                                      : corner.k == 0 ? last
                                                      : next;
        const Vec2f from[3] = {first.from, second.from, third.from}, to[3] = {first.to, second.to, third.to};
        return step::free_corners(from, to, step::kSilhouetteLeastShape) >> corner.k & 1u;
    }
    __device__ void mark(unsigned owners) const {
        each_corner([&](const SilhouetteCorner& corner, bool is_one) {
            if (!is_one || !(owners >> corner.owner & 1u)) return;
            std::uint8_t& changed = s_.lattice.changed[corner.triangle];
            if (changed == step::kSame) changed = step::kMoved;
        });
    }

    const SurfaceState& s_;
    const SilhouetteFitArrays& a_;
    const SilhouetteLists<SilhouetteEnd> end_lists_;
    const SilhouetteLists<unsigned> corner_lists_;
    SilhouetteScratch& scratch_;
    const step::PixelView view_;
    SilhouetteSamples samples_;
    const unsigned lane_;
    unsigned vertices_ = 0, ends_ = 0, corners_ = 0;  // numbers of the warp's vertices, ends and corners
    bool fits_ = false;
    // In a vertex's lane:
    unsigned v_ = 0, end_count_ = 0, corner_count_ = 0, first_end_ = 0, first_corner_ = 0;
    Vec2f at_{}, to_{};
    bool marked_ = false;
    SilhouetteCorner corner_{};  // in a corner's lane, of the first 32
    // In an end's lane:
    unsigned owner_ = 0, other_ = 0;
    Vec2f a_at_{}, b_at_{};  // positions of the edge's vertices
    SilhouetteSeen seen_;
};

}  // namespace hexrelief::cuda
