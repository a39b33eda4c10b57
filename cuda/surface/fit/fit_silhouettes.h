// Silhouette vertices fitted to the crack edges with a discontinuity.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/fit/fit_silhouettes_step.h"

namespace hexrelief::cuda {

// One end of an edge along a silhouette.
struct SilhouetteEnd {
    unsigned key;    // 3 * triangle + corner, by which edges are summed
    unsigned other;  // 2 * the vertex at the other end + whether this is the edge's second
};

// Where a silhouette vertex would go, and where it is. Read and written as a whole.
struct alignas(16) SilhouetteMove {
    Vec2f to, from;
};

struct SilhouetteTotals {
    unsigned vertices;
    unsigned ends_full, corners_full;  // whether a vertex has more than there is capacity for at first
};

// Each vertex has capacity for so many at first; with more, all are sorted into lists without gaps.
inline constexpr unsigned kEndCapacity = 8, kSilhouetteCornerCapacity = 16;

struct SilhouetteFitArrays {
    SilhouetteTotals* totals;
    unsigned *end_counts, *corner_counts;  // of vertices; 0, as totals are, but while in use
    unsigned *first_ends, *first_corners;  // of vertices where there was no capacity
    unsigned* vertices;                    // on silhouettes, in no order
    SilhouetteEnd* ends;
    unsigned* corners;      // 3 * triangle + corner
    SilhouetteMove* moves;  // of each vertex in every round
    Vec2f* points;          // of each vertex after every round but the last
    std::uint8_t* moved;
};

// Of end_counts, corner_counts and totals, which follow each other.
inline std::size_t silhouette_count_bytes(const SurfaceSizes& sizes) {
    return 2 * sizeof(unsigned) * sizes.most_points + sizeof(SilhouetteTotals);
}

inline SilhouetteFitArrays take_silhouette_fit_arrays(const SurfaceSizes& sizes, Arena& arena) {
    const std::size_t points = sizes.most_points;
    SilhouetteFitArrays a{};
    a.end_counts = arena.take<unsigned>(silhouette_count_bytes(sizes) / sizeof(unsigned));
    a.corner_counts = a.end_counts + points;
    a.totals = reinterpret_cast<SilhouetteTotals*>(a.corner_counts + points);
    for (unsigned** each : {&a.first_ends, &a.first_corners, &a.vertices})
        *each = arena.take<unsigned>(points);
    a.ends = arena.take<SilhouetteEnd>(kEndCapacity * points);  // at most 6 on the average
    a.corners = arena.take<unsigned>(kSilhouetteCornerCapacity * points);
    a.moves = arena.take<SilhouetteMove>(step::kSilhouetteRounds * points);
    a.points = arena.take<Vec2f>((step::kSilhouetteRounds - 1) * points);
    a.moved = arena.take<std::uint8_t>(points);
    return a;
}

// Whether a block gets as much shared memory as it takes: from compute capability 8.0 on.
bool can_fit_silhouettes();

// Before the first fit_silhouettes().
void begin_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a);

// As SilhouetteFitter::fit(): moves s.lattice.points and marks s.lattice.changed; reads s.pixels,
// s.labels.kept and s.labels.open, and the flag words of the labels.
void fit_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a, uint4* words);

}  // namespace hexrelief::cuda
