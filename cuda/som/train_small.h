// Training of one small level on the device, without a barrier of the grid.
#pragma once

#include <cstddef>

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// The units of a batch as the triggering step reads them: one record a point, two sets used alternately.
struct SmallView {
    uint4* records;  // 2 x prr x `capacity`
    std::uint32_t capacity;
};

// Whether train_small takes the level: its cell lists fit a block's shared memory, and it has few enough
// points for each patch of neurons to read all of an iteration.
bool is_small(const LevelView& level);

// Records that train_small needs for a level whose longest batch holds `longest` iterations.
std::size_t small_records(const Launch& launch, const LevelView& level, int longest);

// Once a level, before its training.
void clear_small(const Launch& launch, const LevelView& level, uint4* records, int longest);

// As train() in train_large.h. Precondition: is_small.
void train_small(const Launch& launch, const LevelView& level, uint4* records, const IterationRange& range);

}  // namespace hexrelief::cuda
