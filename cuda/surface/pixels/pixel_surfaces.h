// Finds which neighbouring pixels lie on one surface.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/pixels/pixel_surfaces_step.h"

namespace hexrelief::cuda {

// Returns the arrays of the search; those of the result are left to the state.
inline step::PixelArrays take_pixel_arrays(const SurfaceSizes& sizes, Arena& arena) {
    step::PixelArrays a{};
    const std::size_t pixels = sizes.pixels(), words = step::hole_words(sizes.width, sizes.height),
                      entries = words * step::kHoleWord + 1;
    a.words = arena.take<unsigned>(words);
    a.numbers = arena.take<unsigned>(words);
    a.roots = arena.take<unsigned>(entries);
    a.areas = arena.take<unsigned>(entries);
    a.pending = arena.take<unsigned>(pixels);
    a.found = arena.take<float>(pixels);
    a.counts = arena.take<step::PixelArrays::Counts>(1);
    return a;
}

// Reads s.pixels.map, fills the rest of s.pixels and the totals.
void find_pixel_surfaces(const Launch& launch, const SurfaceState& s, step::PixelArrays arrays);

}  // namespace hexrelief::cuda
