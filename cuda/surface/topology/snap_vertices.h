// Moves lattice vertices onto silhouettes.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/pixels/crack_query.h"
#include "mesher/surface/topology/snap_vertices_step.h"

namespace hexrelief::cuda {

// Read and written as a whole, so that a thread that sees a vertex done also sees its final position.
struct alignas(16) SnapVertex {
    static constexpr unsigned kStayed = 1, kSnapped = 2;
    float x, y;
    float share;    // of the way to the nearest crossing; below 0: none
    unsigned done;  // 0 = not yet done, or kStayed, kSnapped

    HEXRELIEF_HD bool on_silhouette() const { return done == kSnapped; }
    HEXRELIEF_HD Vec2f point() const { return {x, y}; }
};

struct SnapArrays {
    SnapVertex* vertices;
    SilhouetteArrays silhouettes;
    float (*shares)[6];   // crossings of the edges to the neighbours
    Vec2f* targets;       // the silhouette's point nearest to a vertex
    std::uint16_t* seen;  // kFresh, and bits of the neighbours that lay on silhouettes at the last refresh
    std::uint32_t* candidates;
    std::uint32_t* queries;  // vertices whose edges are tested first
    unsigned* counts;        // of candidates, of queries, and of queries taken
};

inline SnapArrays take_snap_arrays(const SurfaceSizes& sizes, Arena& arena) {
    const std::size_t count = sizes.vertices();
    SnapArrays a;
    a.silhouettes = take_silhouette_arrays(sizes, arena);
    a.targets = arena.take<Vec2f>(count);
    a.vertices = arena.take<SnapVertex>(count);
    a.shares = reinterpret_cast<float(*)[6]>(arena.take<float>(6 * count));
    a.seen = arena.take<std::uint16_t>(count);
    a.candidates = arena.take<std::uint32_t>(count);
    a.queries = arena.take<std::uint32_t>(count);
    a.counts = arena.take<unsigned>(3);
    return a;
}

// Does the same as surface::snap_to_silhouettes(): moves s.lattice.points and fills
// s.lattice.on_silhouette. It reads the pixels with their discontinuities.
void snap_to_silhouettes(const Launch& launch, const SurfaceState& s, const SnapArrays& a);

}  // namespace hexrelief::cuda
