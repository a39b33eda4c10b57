// Trains one small level on the device, without barriers of the whole grid.
#pragma once

#include <cstddef>

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// The units of a batch as the triggering step reads them: one record per point, in two sets used in turn.
struct SmallView {
    uint4* records;  // 2 x prr x `capacity`
    std::uint32_t capacity;
};

// True if train_small() can train the level: its cell lists fit into a block's shared memory, and it has few
// enough points that each patch of neurons can read all those of an iteration.
bool is_small(const LevelView& level);

// Returns the number of records that train_small() needs for a level whose longest
// batch has `longest` iterations.
std::size_t small_records(const Launch& launch, const LevelView& level, int longest);

// Prepares a level's records and positions; to be called once before its training.
void clear_small(const Launch& launch, const LevelView& level, uint4* records, int longest);

// Does the same as train() in level.h. Requires is_small(level).
void train_small(const Launch& launch, const LevelView& level, uint4* records, const IterationRange& range);

}  // namespace hexrelief::cuda
