// A table of the silhouette's points at all crack edges.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/pixels/edge_crossings_step.h"

namespace hexrelief::cuda {

struct alignas(16) SilhouetteEntry {
    step::SilhouettePoint point;
};

// The silhouette's point at each crack edge, computed once. Those beyond the capacity are
// computed at each query.
struct SilhouetteArrays {
    // Per pixel with discontinuities the index of its first entry, right before down;
    // undefined for other pixels.
    std::uint32_t* firsts;
    SilhouetteEntry* entries;
    unsigned* count;
    unsigned capacity;
};

inline SilhouetteArrays take_silhouette_arrays(const SurfaceSizes& sizes, Arena& arena) {
    SilhouetteArrays a;
    a.capacity = sizes.pixels() / 4 + 64;
    a.firsts = arena.take<std::uint32_t>(sizes.pixels() + 3);
    a.entries = arena.take<SilhouetteEntry>(a.capacity);
    a.count = arena.take<unsigned>(1);
    return a;
}

}  // namespace hexrelief::cuda
