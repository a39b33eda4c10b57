// Rims at high depth jumps that end inside of their own surfaces, as mesher/inset_rims.cpp does.
#pragma once

#include "cuda/sheet_rims.cuh"
#include "mesher/steps/rim_inset.h"

namespace hexrelief::cuda {

// The arrays of the rims' fit serve here as well: of sheet_points and sheet_triangles, which sizes hold.
// Moves s.sheet.points; reads s.sheet.triangles and olds, s.pixels.
template <typename Crew>
__device__ void inset_rims(const Crew& crew, const SheetState& s, const RimFitArrays& a) {
    const unsigned points = s.totals->sheet_points, corners = 3 * s.totals->sheet_triangles;
    const step::PixelView view = s.view();
    const float width = static_cast<float>(view.width), height = static_cast<float>(view.height);
    crew.each(points, [&](unsigned v) {
        a.corner_counts[v] = 0;
        if (v == 0) *a.totals = {};
    });
    for (unsigned v = crew.thread(); v < points; v += crew.threads()) {
        const std::uint32_t *olds = s.sheet.olds, old = olds[v];
        const bool doubled = (v > 0 && olds[v - 1] == old) || (v + 1 < points && olds[v + 1] == old);
        a.moved[v] = step::is_inset(step::rim_step_at(view, s.pixels.map, s.sheet.points[v]), doubled);
        a.targets[v] = s.sheet.points[v];
    }
    crew.each(corners, [&](unsigned i) {
        a.corner_slots[i] = atomicAdd(&a.corner_counts[s.sheet.triangles[i / 3][i % 3]], 1);
    });
    for (unsigned start = crew.thread() - crew.lane(); start < points; start += crew.threads()) {
        const unsigned v = start + crew.lane();
        const unsigned count = v < points && a.moved[v] ? a.corner_counts[v] : 0;
        const RimVertex rim{v, 0, count, 0, claim(&a.totals->corners, count)};
        const unsigned at = claim(&a.totals->vertices, count > 0);
        if (count == 0) continue;
        a.vertices[at] = rim;
        a.first_corners[v] = rim.first_corner;
    }
    crew.wait();
    crew.each(corners, [&](unsigned i) {
        const Triangle& t = s.sheet.triangles[i / 3];
        if (a.moved[t[i % 3]]) a.corners[a.first_corners[t[i % 3]] + a.corner_slots[i]] = {t, i};
    });
    const unsigned vertices = a.totals->vertices;
    crew.each(vertices, [&](unsigned i) {
        const RimVertex rim = a.vertices[i];
        step::Inwards inwards;
        in_order(a.corners + rim.first_corner, rim.corner_count, [&](const RimCorner& corner) {
            const Triangle& t = corner.vertices;
            const Vec2f at[3] = {s.sheet.points[t[0]], s.sheet.points[t[1]], s.sheet.points[t[2]]};
            step::add_inwards(inwards, at, static_cast<int>(corner.key % 3));
        });
        a.targets[rim.vertex] =
            step::inset_point(s.sheet.points[rim.vertex], inwards, s.settings.rim_inset_px, width, height);
    });
    for (unsigned start = crew.thread() / 32 * 4; start < vertices; start += crew.threads() / 32 * 4) {
        const unsigned i = start + crew.lane() / 8;
        const RimVertex rim = i < vertices ? a.vertices[i] : RimVertex{};
        const bool moves = is_free(a.corners + rim.first_corner, rim.corner_count, s.sheet.points, a.targets,
                                   step::kInsetLeastShape);
        if (i < vertices && crew.lane() % 8 == 0) a.moved[rim.vertex] = moves ? 2 : 1;
    }
    crew.wait();
    crew.each(vertices, [&](unsigned i) {
        const unsigned v = a.vertices[i].vertex;
        if (a.moved[v] == 2) s.sheet.points[v] = a.targets[v];
    });
}

}  // namespace hexrelief::cuda
