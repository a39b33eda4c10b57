// Lists of the mesh edges and triangles at silhouette vertices.
#pragma once

#include "cuda/common/grid.cuh"
#include "cuda/common/warp_reduce.cuh"
#include "cuda/surface/fit/fit_silhouettes.h"

namespace hexrelief::cuda {

// Adds the warp's sum of `count` to *total. Returns the old total plus the sum over the preceding lanes.
__device__ inline unsigned claim(unsigned* total, unsigned count) {
    const unsigned lane = threadIdx.x % 32, sum = sum_up_to_lane(count);
    unsigned before = 0;
    if (lane == 31 && sum > 0) before = atomicAdd(total, sum);
    return __shfl_sync(~0u, before, 31) + sum - count;
}

// Calls visit(item) for all items in ascending order of key_of(item). Meant for few items.
template <typename Item, typename KeyOf, typename Visit>
__device__ void in_order(const Item* items, unsigned count, const KeyOf& key_of, const Visit& visit) {
    unsigned least = 0;
    for (unsigned k = 0; k < count; ++k) {
        unsigned next = ~0u, at = 0;
        for (unsigned i = 0; i < count; ++i) {
            const unsigned key = key_of(items[i]);
            if (key >= least && key < next) next = key, at = i;
        }
        visit(items[at]);
        least = next + 1;
    }
}

// Lists of items, one per vertex, in no particular order.
template <typename Item>
struct SilhouetteLists {
    unsigned *counts, *firsts;
    Item* items;
    unsigned capacity;
    bool packed;  // true if the lists follow each other without gaps

    __device__ unsigned first(unsigned v) const { return packed ? firsts[v] : capacity * v; }
    // Returns the position of the vertex's next item.
    __device__ unsigned count(unsigned v) const { return atomicAdd(&counts[v], 1); }
    // Returns true if there is capacity.
    __device__ bool put(unsigned v, unsigned place, const Item& item) const {
        const bool fits = packed || place < capacity;
        if (fits) items[first(v) + place] = item;
        return fits;
    }
    // Packs the lists without gaps, once all items are counted. put_all() puts all items again.
    template <typename PutAll>
    __device__ void pack(const CooperativeGrid& grid, unsigned vertices, const PutAll& put_all) {
        packed = true;
        exclusive_scan(
            grid, vertices, [&](unsigned v) { return counts[v]; },
            [&](unsigned v, unsigned before) { firsts[v] = before; });
        grid.each(vertices, [&](unsigned v) { counts[v] = 0; });
        put_all();
        grid.wait();
    }
};

__device__ inline SilhouetteLists<unsigned> corner_lists(const SilhouetteFitArrays& a) {
    return {a.corner_counts, a.first_corners, a.corners, kSilhouetteCornerCapacity, false};
}

// Calls visit(i, bits) for each i < count whose bits(i) are not 0, by all lanes of the warp: bits is 0 for
// the other lanes. Each lane loads the bits of several i before it uses them.
template <typename Bits, typename Visit>
__device__ void each_few(const CooperativeGrid& grid, unsigned count, const Bits& bits, const Visit& visit) {
    constexpr unsigned kAtOnce = 4;
    const unsigned threads = grid.threads();
    HEXRELIEF_ROLLED
    for (unsigned first = grid.thread(); first - grid.lane() < count; first += kAtOnce * threads) {
        unsigned all = 0;  // three bits each
#pragma unroll
        for (unsigned k = 0; k < kAtOnce; ++k)
            if (first + k * threads < count) all |= bits(first + k * threads) << 3 * k;
        HEXRELIEF_ROLLED
        for (unsigned i = first; __any_sync(~0u, all); i += threads, all >>= 3)
            if (__any_sync(~0u, all & 7u)) visit(i, all & 7u);
    }
}

// Lists the triangles' corners at the vertices for which is_one(v) is true.
template <typename IsOne>
__device__ void put_corners(const CooperativeGrid& grid, const SilhouetteFitArrays& a,
                            const SilhouetteLists<unsigned>& corners, const Triangle* triangles,
                            unsigned triangle_count, const IsOne& is_one) {
    bool full = false;
    each_few(
        grid, triangle_count,
        [&](unsigned t) {
            const Triangle n = triangles[t];
            return (is_one(n[0]) ? 1u : 0u) | (is_one(n[1]) ? 2u : 0u) | (is_one(n[2]) ? 4u : 0u);
        },
        [&](unsigned t, unsigned ones) {
            const Triangle n = ones ? triangles[t] : Triangle{};
            unsigned places[3] = {};
#pragma unroll
            for (unsigned k = 0; k < 3; ++k)  // all atomics before the first result is used
                if (ones >> k & 1u) places[k] = corners.count(n[k]);
#pragma unroll
            for (unsigned k = 0; k < 3; ++k)
                if (ones >> k & 1u) full |= !corners.put(n[k], places[k], 3 * t + k);
        });
    if (full) a.totals->corners_full = 1;
}

// Lists the ends of silhouette edges at their vertices, and these vertices, followed by a barrier. Calls
// begin(v) for each vertex found.
template <typename Begin>
__device__ SilhouetteLists<SilhouetteEnd> list_ends(const CooperativeGrid& grid, const SurfaceState& s,
                                                    const SilhouetteFitArrays& a, const Begin& begin) {
    SilhouetteLists<SilhouetteEnd> ends{a.end_counts, a.first_ends, a.ends, kEndCapacity, false};
    const unsigned triangles = s.counts->triangles;
    const auto put_all = [&] {
        bool full = false;
        each_few(
            grid, triangles,
            [&](unsigned t) {
                const bool kept = s.labels.kept[t] != 0;
                unsigned silhouettes = 0;
#pragma unroll
                for (unsigned k = 0; k < 3; ++k) {
                    const std::int32_t other = s.lattice.neighbours[t][k];
                    const bool once = other >= static_cast<std::int32_t>(t);  // false at the image's border
                    const bool other_kept = s.labels.kept[once ? static_cast<unsigned>(other) : t] != 0;
                    if (once & step::is_silhouette(kept, other_kept, s.labels.open[t][k] != 0))
                        silhouettes |= 1u << k;
                }
                return silhouettes;
            },
            [&](unsigned t, unsigned silhouettes) {
                const Triangle n = silhouettes ? s.lattice.triangles[t] : Triangle{};
                unsigned found = 0;
#pragma unroll
                for (unsigned k = 0; k < 3; ++k) {
                    if (!(silhouettes >> k & 1u)) continue;
                    const unsigned v = n[k], w = n[(k + 1) % 3];
                    const unsigned v_place = ends.count(v), w_place = ends.count(w);
                    const bool fit = ends.put(v, v_place, {3 * t + k, 2 * w}),
                               fits = ends.put(w, w_place, {3 * t + k, 2 * v + 1});
                    if (v_place == 0) found |= 1u << k;
                    if (w_place == 0) found |= 1u << (k + 1) % 3;
                    full |= !fit || !fits;
                }
                if (ends.packed) return;
                unsigned at = claim(&a.totals->vertices, __popc(found));
#pragma unroll
                for (unsigned k = 0; k < 3; ++k) {
                    if (!(found >> k & 1u)) continue;
                    a.vertices[at++] = n[k];
                    begin(n[k]);
                }
            });
        if (full) a.totals->ends_full = 1;
    };
    put_all();
    grid.wait();
    if (a.totals->ends_full) ends.pack(grid, s.counts->points, put_all);
    return ends;
}

}  // namespace hexrelief::cuda
