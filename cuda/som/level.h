// One level of the map on the device: trivial views that kernels take by value.
#pragma once

#include <cuda_runtime_api.h>

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "mesher/common/mesh_config.h"
#include "mesher/som/level_plan.h"

namespace hexrelief::cuda {

inline constexpr int kTableWidth = 32;  // entries of a learning table: one a lane
inline constexpr int kMostRadius = 27;  // a patch of 8 columns then sees 64 columns, the bits of one integer

// The points that each neuron won in an iteration, summed. Each iteration of a batch has three sets, used
// alternately: one is added to, one is read, one is cleared.
struct UnitSums {
    uint4* sums;          // one a neuron: count, x, y in half px
    std::uint32_t* mask;  // one bit a neuron: count > 0; `words` words a lattice row
};

// A neuron as the search for best matching units sees it. It is read and written as a whole: a reader that
// finds the batch that it waits for has the position of that batch, too.
struct alignas(16) SortedNeuron {
    float x, y;
    std::uint32_t id, batch;
};

struct LevelView {
    step::CellGrid grid;
    step::Lattice lattice;
    float extent_x, extent_y;
    int level, ssr, words;
    bool pinned;
    step::Outline outline;  // of the lattice's ends, on the device
    std::uint64_t seed;
    std::uint32_t cell_factor;  // divisor(2 co): half px to cells
    // cellular matrix
    std::uint32_t* cumulative;    // weights summed up within each cell; one a pixel, cell after cell
    std::uint32_t* sums;          // one a cell
    std::uint64_t* activity;      // one a cell
    std::uint32_t* largest;       // [0] float bits of the largest density, [1] largest cell sum
    std::uint32_t* begin;         // a row of cells is one range of `sorted`: columns + 1 bounds a row
    std::uint32_t* filled;        // one a cell
    std::uint32_t* arrived;       // blocks at the barriers so far
    std::uint32_t* cursor;        // right behind it
    SortedNeuron* sorted;         // neurons in the order of their cells
    std::uint32_t* sorted_index;  // of each neuron in that order
    // points drawn ahead, for a batch of iterations: x | y << 16 in half px
    std::uint32_t* points;
    std::uint32_t* point_count;  // one an iteration of the batch
    std::uint32_t point_capacity;
    // learning
    const std::uint32_t* gain;  // kTableWidth an iteration
    const std::uint32_t* decay;
    const int* radius;  // one an iteration
    UnitSums units;     // 3 sets for each iteration of a batch, one after the other
    float *x, *y;       // positions, px
};

// What the lattice is pinned to.
__host__ __device__ inline step::Border border_of(const LevelView& level) {
    return {level.lattice, level.outline, level.extent_x, level.extent_y};
}

// Iterations [first, first + count) of a level: refreshed every crr, of which `first` is a multiple, and in
// batches of prr <= kMostBatch.
struct IterationRange {
    int first, count, crr, prr;
};

// Division of integers below 65536 by one of 1..65535 as a multiplication: high word of n * divisor(d).
inline std::uint32_t divisor(int d) {
    return static_cast<std::uint32_t>(0xFFFFFFFFu / static_cast<std::uint32_t>(d) + 1);
}

}  // namespace hexrelief::cuda
