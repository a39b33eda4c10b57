// The steps around the training on the device: start positions, finer levels, repair of folds.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Sets the regular positions of the level, with the border on the area's if it is pinned.
void place_regular(const Launch& launch, const LevelView& level);

// Sets the positions of `to` from those of the next coarser level.
void prolongate(const Launch& launch, const LevelView& from, const LevelView& to);

// Scratch memory of untangle(): two bytes and two floats per neuron, and a flag per sweep.
struct UntangleScratch {
    std::uint8_t *smoothed, *before;
    float *x, *y;
    int* any;  // step::kMostUntangleSweeps + 1
};

// Repairs folded triangles in place, as som::untangle does, and waits for the stream. held: one per
// vertex, nonzero if the vertex may not move; null: all may move.
void untangle(const Launch& launch, const LevelView& level, const UntangleScratch& scratch,
              const std::uint8_t* held = nullptr);

// Moves all vertices by (x, y) px.
void shift(const Launch& launch, const LevelView& level, float x, float y);

}  // namespace hexrelief::cuda
