// Rims at high depth jumps that end inside of their own surfaces, as mesher/inset_rims.cpp does.
#pragma once

#include "cuda/surface/fit/silhouette_lists.cuh"
#include "mesher/surface/fit/triangle_shape_step.h"
#include "mesher/surface/fit/inset_silhouettes_step.h"

namespace hexrelief::cuda {

// Whether the i-th of `count` vertices may move, i = thread / 8: asked by eight threads, who look at
// `corner_count` of its corners. All of a warp call it.
__device__ inline bool is_free(const SheetState& s, const unsigned* corners, unsigned corner_count,
                               const Vec2f* targets) {
    const unsigned lane = threadIdx.x % 32;
    const Vec2f* const points = s.sheet.points;
    const step::FanView<const std::int32_t(*)[3], const std::uint8_t(*)[3]> fans{
        s.lattice.triangles, s.lattice.neighbours, s.sides.open, s.sides.kept};
    bool free = true;
    for (unsigned c = lane % 8; c < corner_count; c += 8) {
        const unsigned number = corners[c] / 3, k = corners[c] % 3;
        const Triangle& t = s.sheet.triangles[number];
        const step::Corner own{s.sheet.origins[number], k};
        const Vec2f from[3] = {points[t[0]], points[t[1]], points[t[2]]};
        const Vec2f to[3] = {targets[t[0]], targets[t[1]], targets[t[2]]};
        free = free && (step::free_corners(from, to, step::kInsetLeastShape) >> k & 1) &&
               !step::uncovers_surface(s.view(), fans, own, from, to);
    }
    return (__ballot_sync(~0u, free) >> (lane & 24) & 0xff) == 0xff;
}

// The arrays of the rims' fit serve here as well: of sheet_points and sheet_triangles, which sizes hold.
// Moves s.sheet.points; reads s.sheet.triangles and olds, s.pixels.
template <typename Crew>
__device__ void inset_rims(const Crew& crew, const SheetState& s, const RimFitArrays& a) {
    const unsigned points = s.totals->sheet_points;
    const step::PixelView view = s.view();
    const float width = static_cast<float>(view.width), height = static_cast<float>(view.height);
    Vec2f* const targets = a.points;
    for (unsigned start = crew.thread() - crew.lane(); start < points; start += crew.threads()) {
        const unsigned v = start + crew.lane();
        bool moves = false;
        if (v < points) {
            const std::uint32_t *olds = s.sheet.olds, old = olds[v];
            const bool doubled = (v > 0 && olds[v - 1] == old) || (v + 1 < points && olds[v + 1] == old);
            moves = step::is_inset(step::rim_step_at(view, s.pixels.map, s.sheet.points[v]), doubled);
            a.moved[v] = moves;
            targets[v] = s.sheet.points[v];
        }
        const unsigned at = claim(&a.totals->vertices, moves);
        if (moves) a.vertices[at] = v;
    }
    crew.wait();
    const unsigned vertices = a.totals->vertices;
    RimLists<unsigned> corners = corner_lists(a);
    const auto put = [&] {
        put_corners(crew, a, corners, s.sheet.triangles, s.totals->sheet_triangles,
                    [&](unsigned v) { return a.moved[v] != 0; });
    };
    put();
    crew.wait();
    if (a.totals->corners_full) corners.pack(crew, points, put);
    crew.each(vertices, [&](unsigned i) {
        const unsigned v = a.vertices[i];
        step::Inwards inwards;
        in_order(
            a.corners + corners.first(v), a.corner_counts[v], [](unsigned corner) { return corner; },
            [&](unsigned corner) {
                const Triangle& t = s.sheet.triangles[corner / 3];
                const Vec2f at[3] = {s.sheet.points[t[0]], s.sheet.points[t[1]], s.sheet.points[t[2]]};
                step::add_inwards(inwards, at, static_cast<int>(corner % 3));
            });
        targets[v] = step::inset_point(s.sheet.points[v], inwards, s.settings.rim_inset_px, width, height);
    });
    for (unsigned start = crew.thread() / 32 * 4; start < vertices; start += crew.threads() / 32 * 4) {
        const unsigned i = start + crew.lane() / 8;
        const unsigned v = i < vertices ? a.vertices[i] : 0;
        const bool moves =
            is_free(s, a.corners + corners.first(v), i < vertices ? a.corner_counts[v] : 0, targets);
        if (i < vertices && crew.lane() % 8 == 0) a.moved[v] = moves ? 2 : 1;
    }
    crew.wait();
    crew.each(vertices, [&](unsigned i) {
        const unsigned v = a.vertices[i];
        if (a.moved[v] == 2) s.sheet.points[v] = targets[v];
    });
}

}  // namespace hexrelief::cuda
