// What surrounds the training on the device: initial positions, levels, repair of folds.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Regular positions of the level (on the image's border where pinned).
void place_regular(const Launch& launch, const LevelView& level);

// Positions of `to` from those of the next coarser level.
void prolongate(const Launch& launch, const LevelView& from, const LevelView& to);

// Scratch of untangle: two bytes and two floats for each neuron, and a flag for each sweep.
struct UntangleScratch {
    std::uint8_t *smoothed, *before;
    float *x, *y;
    int* any;  // step::kMostUntangleSweeps + 1
};

// Repairs folded triangles in place, as som::untangle does; waits for the stream. held: one a vertex,
// not 0 where it may not move; null: all move.
void untangle(const Launch& launch, const LevelView& level, const UntangleScratch& scratch,
              const std::uint8_t* held = nullptr);

// Moves all vertices by (x, y) px.
void shift(const Launch& launch, const LevelView& level, float x, float y);

}  // namespace hexrelief::cuda
