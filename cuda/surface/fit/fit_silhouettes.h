// Fits silhouette vertices to crack edges, and insets silhouettes at high depth discontinuities into their
// own surfaces.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/fit/disparity_fitter_step.h"
#include "mesher/surface/fit/fit_silhouettes_step.h"
#include "mesher/surface/fit/inset_silhouettes_step.h"

namespace hexrelief::cuda {

// One end of a mesh edge along a silhouette.
struct SilhouetteEnd {
    unsigned key;    // 3 * triangle + corner, by which edges are ordered in sums
    unsigned other;  // 2 * the vertex at the other end + 1 if this is the edge's second end
};

// The target of a silhouette vertex, and its position. Read and written as a whole.
struct alignas(16) SilhouetteMove {
    Vec2f to, from;
};

struct SilhouetteTotals {
    unsigned vertices;
    unsigned ends_full, corners_full;  // nonzero if a vertex has more than its first capacity
};

// First capacity of each vertex; if one needs more, all are sorted into lists without gaps.
inline constexpr unsigned kEndCapacity = 8, kSilhouetteCornerCapacity = 16;

struct SilhouetteFitArrays {
    SilhouetteTotals* totals;
    unsigned *end_counts, *corner_counts;  // per vertex; 0 while not in use, and so are the totals
    unsigned *first_ends, *first_corners;  // per vertex, if the first capacity was too small
    unsigned* vertices;                    // on silhouettes, in no particular order
    SilhouetteEnd* ends;
    unsigned* corners;      // as 3 * triangle + corner
    SilhouetteMove* moves;  // per vertex, one for each round
    Vec2f* points;          // per vertex, one after each round except the last
    std::uint8_t* moved;
};

// Bytes of end_counts, corner_counts and totals, which follow each other in memory.
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
    a.ends = arena.take<SilhouetteEnd>(kEndCapacity * points);  // at most 6 on average
    a.corners = arena.take<unsigned>(kSilhouetteCornerCapacity * points);
    a.moves = arena.take<SilhouetteMove>(step::kSilhouetteRounds * points);
    a.points = arena.take<Vec2f>((step::kSilhouetteRounds - 1) * points);
    a.moved = arena.take<std::uint8_t>(points);
    return a;
}

// True if a block gets as much shared memory as the kernel needs, which takes compute capability 8.0.
bool can_fit_silhouettes();

// Clears the counts; to be called before the first fit_silhouettes().
void begin_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a);

// Does the same as SilhouetteFitter::fit(): moves s.lattice.points and marks s.lattice.changed. It reads
// s.pixels, s.labels.kept and s.labels.open, and the labels' flag words.
void fit_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a, uint4* words);

// Returns arrays in the memory of the disparities' fit, which comes later.
inline step::InsetArrays inset_arrays(const step::FitArrays& fit) {
    return {fit.corners, reinterpret_cast<Vec2f*>(fit.values[0]),
            reinterpret_cast<std::uint8_t*>(fit.values[1])};
}

// Does the same as surface::inset_silhouettes(): moves s.cut_mesh.points.
void inset_silhouettes(const Launch& launch, const SurfaceState& s, const step::InsetArrays& a);

}  // namespace hexrelief::cuda
