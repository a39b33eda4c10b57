// Splits triangles where their edges cross silhouettes.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/pixels/crack_query.h"
#include "mesher/surface/topology/split_lattice_step.h"

namespace hexrelief::cuda {

struct SplitArrays : step::SplitArrays {
    SilhouetteArrays silhouettes;  // as snap_to_silhouettes() left them
    std::int32_t* numbers;         // of number_slots()
};

inline SplitArrays take_split_arrays(const SurfaceSizes& sizes, const SilhouetteArrays& silhouettes,
                                     Arena& arena) {
    SplitArrays a{};
    a.silhouettes = silhouettes;
    a.shares =
        reinterpret_cast<float(*)[3]>(arena.take<float>(3 * static_cast<std::size_t>(sizes.most_triangles)));
    a.cuts = arena.take<step::Cut>(sizes.most_triangles);
    a.firsts = arena.take<step::LatticeCounts>(sizes.most_triangles);
    a.list = arena.take<std::uint32_t>(sizes.most_triangles);
    a.count = arena.take<unsigned>(1);
    a.numbers = arena.take<std::int32_t>(2 * static_cast<std::size_t>(sizes.vertices()));
    return a;
}

// Does the same as surface::split_at_silhouettes(): reads s.lattice.points and on_silhouette, writes the
// rest of s.lattice and s.counts.
void split_at_silhouettes(const Launch& launch, const SurfaceState& s, const SplitArrays& a);

// Does the same as surface::split_straddling(): reads s.labels.straddling, changes s.lattice and s.counts.
void split_straddling(const Launch& launch, const SurfaceState& s, const SplitArrays& a);

}  // namespace hexrelief::cuda
