// Finds which neighbouring pixels lie on one surface.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/pixels/discontinuities_step.h"

namespace hexrelief::cuda {

// The layout of words of 32 pixels of a row: bit b of a row's word k is pixel 32 k + b.
struct WordGrid {
    unsigned width, per_row, count;  // width in px; the others in words
    HEXRELIEF_HD unsigned row(unsigned word) const { return word / per_row; }
    HEXRELIEF_HD unsigned first_pixel(unsigned word) const {
        return row(word) * width + 32 * (word % per_row);
    }
};

// Per region of pixels its root and area, indexed by the first pixel of its first run + 1.
struct RegionArrays {
    WordGrid words;
    unsigned* roots;  // pixels + 1 entries, valid where short runs begin
    unsigned* areas;
};

// Counts, zero before each run.
struct PixelCounts {
    struct Speckles {
        unsigned pixels, words, deep_words;
    } holes, speckles;
    unsigned patches;
};

// A patch, on which a warp works at a time, is a row of tiles as wide as a word. This is its number of rows.
inline constexpr unsigned kPatchRows = step::kTile_px;

struct PixelArrays {
    WordGrid words;
    unsigned patches;
    // Words of pixels:
    unsigned* empty;                // pixels without foreground
    unsigned *right, *down;         // pixels on one surface with their right or lower neighbour
    unsigned *speckles, *absorbed;  // the latest speckles, and all found so far
    unsigned *deep, *settled;  // pixels of speckles that are far from all others; the latest ring of them
    // Lists of words and patches:
    unsigned *speckle_words, *deep_words, *stale_patches;
    unsigned* is_stale;         // per patch
    float *nearest, *farthest;  // per patch, px
    RegionArrays regions;
    PixelCounts* counts;
};

inline PixelArrays take_pixel_arrays(const SurfaceSizes& sizes, Arena& arena) {
    const unsigned width = static_cast<unsigned>(sizes.width), height = static_cast<unsigned>(sizes.height),
                   per_row = (width + 31) / 32, words = per_row * height,
                   patches = per_row * ((height + kPatchRows - 1) / kPatchRows);
    const std::size_t entries = std::size_t{sizes.pixels()} + 1;
    const auto numbers = [&](std::size_t count) { return arena.take<unsigned>(count); };
    PixelArrays a{};
    a.words = {width, per_row, words};
    a.patches = patches;
    for (unsigned** array : {&a.empty, &a.right, &a.down, &a.speckles, &a.absorbed, &a.deep, &a.settled,
                             &a.speckle_words, &a.deep_words})
        *array = numbers(words);
    a.stale_patches = numbers(patches);
    a.is_stale = numbers(patches);
    a.nearest = arena.take<float>(patches);
    a.farthest = arena.take<float>(patches);
    a.regions = {a.words, numbers(entries), numbers(entries)};
    a.counts = arena.take<PixelCounts>(1);
    return a;
}

// Does the same as surface::find_pixel_surfaces(): reads s.pixels.map, fills the rest of
// s.pixels and the totals.
void find_pixel_surfaces(const Launch& launch, const SurfaceState& s, const PixelArrays& a);

}  // namespace hexrelief::cuda
