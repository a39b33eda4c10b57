// One level of the self-organizing map on the device: trivial views that kernels take by value, and the steps
// of its training (paper, section 4).
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "mesher/common/mesh_config.h"
#include "mesher/som/level_plan.h"

namespace hexrelief::cuda {

inline constexpr int kTableWidth = 32;  // entries of a learning table: one per lane
// so that a patch of 8 columns reads at most 64 columns, the bits of one integer
inline constexpr int kMostRadius = 27;

// The sums of the points that each neuron won in an iteration. Each iteration of a batch has three sets, used
// in turn: one is added to, one is read, one is cleared.
struct UnitSums {
    uint4* sums;          // one per neuron: count, x, y in half px
    std::uint32_t* mask;  // one bit per neuron: count > 0; `words` words per lattice row
};

// A neuron as the search for best matching units reads it. It is read and written as a whole, so that a
// reader that finds the number of the batch it waits for has that batch's position as well.
struct alignas(16) SortedNeuron {
    float x, y;
    std::uint32_t id, batch;
};

// The sizes, parameters and arrays of a level, without ownership.
struct LevelView {
    step::CellGrid grid;
    step::Lattice lattice;
    float extent_x, extent_y;
    int level, ssr, words;
    bool pinned;
    step::Outline outline;  // curves of the lattice's first and last row, on the device
    std::uint64_t seed;
    std::uint32_t cell_factor;  // divisor(2 co), which converts half px to cells
    // Cellular matrix:
    std::uint32_t* cumulative;  // per pixel: prefix sums of the weights within each cell, stored cell by cell
    std::uint32_t* sums;        // one per cell
    std::uint64_t* activity;    // one per cell
    std::uint32_t* largest;     // [0] float bits of the largest density, [1] largest cell sum
    std::uint32_t* begin;       // bounds in `sorted`: a row of cells is one range, with columns + 1 bounds
    std::uint32_t* filled;      // one per cell
    std::uint32_t* arrived;     // number of blocks that have arrived at barriers so far
    std::uint32_t* cursor;      // stored directly behind `arrived`
    SortedNeuron* sorted;       // neurons in the order of their cells
    std::uint32_t* sorted_index;  // per neuron: its index in `sorted`
    // Points drawn ahead for several iterations: x | y << 16 in half px.
    std::uint32_t* points;
    std::uint32_t* point_count;  // one per iteration
    std::uint32_t point_capacity;
    // Learning:
    const std::uint32_t* gain;  // kTableWidth per iteration
    const std::uint32_t* decay;
    const int* radius;  // one per iteration
    UnitSums units;     // 3 sets for each iteration of a batch, one after the other
    float *x, *y;       // positions, px
};

// Returns the border to which the level's lattice is pinned.
__host__ __device__ inline step::Border border_of(const LevelView& level) {
    return {level.lattice, level.outline, level.extent_x, level.extent_y};
}

// Iterations [first, first + count) of a level. Cells are refreshed every crr iterations, and `first` is a
// multiple of crr; batches have prr <= kMostBatch iterations.
struct IterationRange {
    int first, count, crr, prr;
};

// Returns a factor that turns the division of integers below 65536 by d, 1..65535, into a multiplication: n /
// d is the high word of n * divisor(d).
inline std::uint32_t divisor(int d) {
    return static_cast<std::uint32_t>(0xFFFFFFFFu / static_cast<std::uint32_t>(d) + 1);
}

// Runs these iterations of a level of any size in one persistent kernel; level.points must hold the points of
// exactly these iterations, and level.filled must be 0 everywhere.
void train(const Launch& launch, const LevelView& level, const IterationRange& range);

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

// Does the same as train(), without barriers of the whole grid. Requires is_small(level).
void train_small(const Launch& launch, const LevelView& level, uint4* records, const IterationRange& range);

// Computes the cumulative distributions, sums and activities of all cells (Eq. 6 and 7) from the level's
// density, whose maximum must be in largest[0].
void build_distributions(const Launch& launch, const LevelView& level, const float* density, double delta);

// Draws the points of iterations [first, first + count) into level.points. Points do not depend on
// positions, so those of many iterations are drawn together. Their order within an iteration is arbitrary
// and affects no sum.
void draw_points(const Launch& launch, const LevelView& level, int first, int count);

// Sets largest[0] to the bits of the largest of `count` non-negative floats.
void find_largest(const Launch& launch, const float* values, std::size_t count, std::uint32_t* largest);

// Sets weights to (density / largest)^magnification by a table of kMagnificationSteps + 1 entries; 0 if
// all densities are 0.
void magnify(const Launch& launch, const float* density, std::size_t count, const std::uint32_t* largest,
             const float* table, float* weights);

// Computes the next coarser density, of (width + 1) / 2 x (height + 1) / 2 pixels.
void coarsen(const Launch& launch, const float* fine, int width, int height, float* coarse);

}  // namespace hexrelief::cuda
