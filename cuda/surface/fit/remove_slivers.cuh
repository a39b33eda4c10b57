// Takes needles from the sheet, as mesher/drop_needles.cpp does.
#pragma once

#include "cuda/common/grid.cuh"
#include "cuda/common/surface_state.cuh"
#include "mesher/surface/fit/remove_slivers_step.h"

namespace hexrelief::cuda {

struct NeedleArrays {
    std::uint8_t *needles, *used;  // of triangles; of vertices
    unsigned* places;              // of vertices, and of the first triangle behind them
    Vec2f* points;                 // as they will be,
    float* disparities;
    Triangle* triangles;  // in the same row of places as the vertices
};

template <typename Take>
NeedleArrays take_needle_arrays(const SheetSizes& sizes, const Take& take) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles;
    NeedleArrays a{};
    a.needles = take.template operator()<std::uint8_t>(triangles);
    a.used = take.template operator()<std::uint8_t>(points);
    a.places = take.template operator()<unsigned>(points + 1);
    a.points = take.template operator()<Vec2f>(points);
    a.disparities = take.template operator()<float>(points);
    a.triangles = take.template operator()<Triangle>(points + triangles);
    return a;
}

// After fit_disparities(), where the sheet is cut and not bridged: takes the needles from s.sheet's points,
// disparities and triangles, and from the totals.
template <typename Crew>
__device__ void drop_needles(Crew& crew, const SheetState& s, const NeedleArrays& a) {
    const unsigned points = s.totals->sheet_points, triangles = s.totals->sheet_triangles;
    const SheetParts& sheet = s.sheet;
    bool mine = false;
    for (unsigned t = crew.thread(); t < triangles; t += crew.threads()) {
        const Triangle v = sheet.triangles[t];
        a.needles[t] = step::is_needle(sheet.points[v[0]], sheet.points[v[1]], sheet.points[v[2]],
                                       sheet.disparities[v[0]], sheet.disparities[v[1]],
                                       sheet.disparities[v[2]], s.totals->jump_px);
        mine |= a.needles[t] != 0;
    }
    for (unsigned v = crew.thread(); v < points; v += crew.threads()) a.used[v] = 0;
    if (!crew.any(mine)) return;
    crew.each(triangles, [&](unsigned t) {
        if (a.needles[t] == 0)
            for (const unsigned v : sheet.triangles[t]) a.used[v] = 1;
    });
    // Vertices and triangles are counted in one row.
    const unsigned all = crew.scan(
        points + triangles,
        [&](unsigned i) -> unsigned { return i < points ? a.used[i] : a.needles[i - points] == 0; },
        [&](unsigned i, unsigned before) {
            if (i <= points) a.places[i] = before;
            if (i >= points) {
                if (a.needles[i - points] == 0) a.triangles[before] = sheet.triangles[i - points];
            } else if (a.used[i] != 0) {
                a.points[before] = sheet.points[i];
                a.disparities[before] = sheet.disparities[i];
            }
        });
    const unsigned used = a.places[points];
    if (crew.thread() == 0) {
        s.totals->sheet_points = used;
        s.totals->sheet_triangles = all - used;
    }
    crew.each(all, [&](unsigned i) {
        if (i < used) {
            sheet.points[i] = a.points[i];
            sheet.disparities[i] = a.disparities[i];
        } else {
            const Triangle v = a.triangles[i];
            sheet.triangles[i - used] = {a.places[v[0]], a.places[v[1]], a.places[v[2]]};
        }
    });
}

}  // namespace hexrelief::cuda
