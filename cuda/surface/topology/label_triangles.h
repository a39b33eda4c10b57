// Labels each triangle with the surface that it lies on, and decides which edges of triangles are open.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"

namespace hexrelief::cuda {

// Successive pixels of a row without a discontinuity between them, and an earlier segment of its component
// or the segment itself.
struct RowSegment {
    std::uint32_t first, end, parent;
};
// The components of one triangle.
struct ComponentArrays {
    RowSegment* segments;
    unsigned* areas;  // of components, stored at their first segments
};

// The data that one update leaves to the next.
struct LabelArrays {
    // Counts of a list: triangles with few rows; and triangles with many rows, which are processed first and
    // are stored at the end of the list.
    struct Listed {
        unsigned few, many;
        HEXRELIEF_HD unsigned all() const { return few + many; }
    };
    struct Counts {
        Listed changed;      // on the first list: triangles whose pixels have changed
        Listed several;      // on the second list: triangles that may have several components
        Listed voting;       // on the first list: triangles whose edges have to be voted on
        unsigned taken[3];   // items handed out
        unsigned pool_used;  // in the current update
    };
    Counts* counts;
    uint4* words;                 // of FlagWords
    std::uint32_t* triangle_ids;  // per pixel: step::triangle_id() of its triangle
    Vec2f (*corners)[3];          // per triangle: its corners when its pixels were found
    std::uint8_t* states;         // per triangle: kPlain ...
    std::uint8_t* marks;          // per triangle: the number of the vote in which it takes part
    std::uint32_t* row_counts;    // per triangle: rows with pixels; on the second list: segments of rows
    unsigned* lists[2];           // of triangles
    ComponentArrays pool;         // for the components of large triangles

    enum State : std::uint8_t {
        kPlain = 1,
        kTrusted = 2,
        kAny = 4
    };  // no discontinuity; no speckle; has pixels
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
    // Uses the memory of the runs, which are written once all labels are known.
    static_assert(sizeof(RowSegment) == sizeof(surface::PixelRun) &&
                  alignof(RowSegment) == alignof(surface::PixelRun));
    a.pool = {reinterpret_cast<RowSegment*>(runs), arena.take<unsigned>(run_capacity(sizes))};
    return a;
}

// Does the same as TriangleLabeler::update(): reads the pixels and s.lattice, writes s.labels except for its
// runs. first: there is no preceding update.
void label_triangles(const Launch& launch, const SurfaceState& s, const LabelArrays& a, bool first);

// Does the same as TriangleLabeler::open_edges(): writes s.labels.open. To be called after label_triangles().
void open_edges(const Launch& launch, const SurfaceState& s, const LabelArrays& a);

}  // namespace hexrelief::cuda
