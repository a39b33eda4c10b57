// Rim vertices fitted to the pixel sides with a jump, as mesher/fit_rims.cpp does.
#pragma once

#include "cuda/surface/fit/silhouette_warp.cuh"

namespace hexrelief::cuda {

// Before the first call of fit_rims(), with a barrier between.
template <typename Crew>
__device__ void begin_rims(const Crew& crew, const SheetState& s, const RimFitArrays& a) {
    if (crew.thread() == 0) *a.totals = {};
    for (unsigned v = crew.thread(); v < s.sizes.most_points; v += crew.threads())
        a.end_counts[v] = a.corner_counts[v] = 0;
}

// Moves s.lattice.points and marks s.lattice.changed; reads s.pixels, s.sides.kept and s.sides.open. words:
// as FlagWords has filled them.
// least_move_px: vertices that would go less far stay.
template <typename Crew>
__device__ void fit_rims(const Crew& crew, const SheetState& s, const RimFitArrays& a, uint4* words,
                         float least_move_px) {
    extern __shared__ float4 rim_rooms[];
    const unsigned points = block_counts().points, triangles = block_counts().triangles;
    // a barrier less, and a few corners more
    const bool all = triangles <= crew.threads();
    RimLists<unsigned> corners = corner_lists(a);
    const auto put = [&] {
        put_corners(crew, a, corners, s.lattice.triangles, triangles,
                    [&](unsigned v) { return all || a.end_counts[v] > 0; });
    };
    if (all) put();
    const RimLists<RimEnd> ends = list_ends(crew, s, a, [&](unsigned v) { RimWarp::clear(a, v); });
    const unsigned count = a.totals->vertices;
    if (!all && count > 0) {
        put();
        crew.wait();
    }
    if (a.totals->corners_full) corners.pack(crew, points, put);
    // A warp has its vertices to itself from the first round to the last. They lie far apart: neighbours are
    // alike, and those with long edges would take one warp long. In rows of four, cones at 1800x1500 took 12
    // % more.
    const unsigned warps = crew.threads() / 32;
    const bool keeps = count <= RimWarp::kVertices * warps;
    RimWarp warp(s, a, words, ends, corners, reinterpret_cast<RimRoom*>(rim_rooms)[threadIdx.x / 32],
                 least_move_px);
    HEXRELIEF_ROLLED
    for (int half = 0; half < 2 * step::kRimRounds; ++half) {
        const int round = half / 2;
        const bool after = half % 2 == 1, fresh = half == 0 || !keeps;
        HEXRELIEF_ROLLED
        for (unsigned v = crew.warp(); v < count; v += RimWarp::kVertices * warps) {
            if (fresh)
                warp.begin(v, warps, min(RimWarp::kVertices, (count - v + warps - 1) / warps), round, after);
            if (after)
                warp.move(round);
            else
                warp.find_targets(round, fresh);
        }
    }
    crew.wait();
    for (unsigned i = crew.thread(); i < (all ? points : count); i += crew.threads()) {
        const unsigned v = all ? i : a.vertices[i];
        a.end_counts[v] = a.corner_counts[v] = 0;
    }
    if (crew.thread() == 0) *a.totals = {};
}

}  // namespace hexrelief::cuda
