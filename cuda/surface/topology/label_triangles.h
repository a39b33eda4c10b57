// Which surface each triangle lies on.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"

namespace hexrelief::cuda {

// Pixels of a row without a discontinuity between them, and an earlier segment of its component, or itself.
struct RowSegment {
    std::uint32_t first, end, parent;
};
// Of a triangle.
struct ComponentArrays {
    RowSegment* segments;
    unsigned* areas;  // of components, at their first segments
};

// What is known from one update to the next.
struct LabelArrays {
    // Of a list: triangles of few rows, and of many, which come first and stand at the end of its capacity.
    struct Listed {
        unsigned few, many;
        HEXRELIEF_HD unsigned all() const { return few + many; }
    };
    struct Counts {
        Listed changed;      // on the first list: have other pixels,
        Listed several;      // on the second: of several components, perhaps
        Listed voting;       // on the first: edges to be looked at
        unsigned taken[3];   // of what is dealt out
        unsigned pool_used;  // in this update
    };
    Counts* counts;
    uint4* words;                 // FlagWords
    std::uint32_t* triangle_ids;  // a pixel: step::triangle_id() its triangle
    Vec2f (*corners)[3];          // a triangle: when its pixels were found
    std::uint8_t* states;         // a triangle: kPlain ...
    std::uint8_t* marks;          // a triangle: the vote that it is to take part in
    std::uint32_t* row_counts;    // a triangle: rows with pixels; on the second list: segments of rows
    unsigned* lists[2];           // of triangles
    ComponentArrays pool;         // for the components of large triangles

    enum State : std::uint8_t {
        kPlain = 1,
        kTrusted = 2,
        kAny = 4
    };  // no discontinuity; no speckle; pixels in it
};

inline LabelArrays take_label_arrays(const SurfaceSizes& sizes, surface::PixelRun* runs, Arena& arena) {
    LabelArrays a{};
    a.counts = arena.take<LabelArrays::Counts>(1);
    a.words = arena.take<uint4>(std::size_t{flag_words_per_row(sizes.width)} * sizes.height);
    a.triangle_ids = arena.take<std::uint32_t>(sizes.pixels());
    a.corners = reinterpret_cast<Vec2f(*)[3]>(arena.take<Vec2f>(3 * std::size_t{sizes.most_triangles}));
    a.states = arena.take<std::uint8_t>(sizes.most_triangles);
    a.marks = arena.take<std::uint8_t>(sizes.most_triangles);
    a.row_counts = arena.take<std::uint32_t>(sizes.most_triangles);
    for (unsigned*& list : a.lists) list = arena.take<unsigned>(sizes.most_triangles);
    // where the runs will be when all labels are known
    static_assert(sizeof(RowSegment) == sizeof(surface::PixelRun) &&
                  alignof(RowSegment) == alignof(surface::PixelRun));
    a.pool = {reinterpret_cast<RowSegment*>(runs), arena.take<unsigned>(run_capacity(sizes))};
    return a;
}

// As TriangleLabeler::update(): reads the pixels and s.lattice, writes s.labels but its runs. first: nothing
// is known from an update before.
void label_triangles(const Launch& launch, const SurfaceState& s, const LabelArrays& a, bool first);

}  // namespace hexrelief::cuda
