// The units of large levels: the sums of the points that each neuron won, in one set per iteration
// of a batch, and device functions that add to, read and clear these sets, each by a warp.
// Included only by train_large.cu.
#pragma once

#include "cuda/som/search.cuh"

namespace hexrelief::cuda {

// Adds a point to the sums of the neuron that won it.
__device__ __forceinline__ void add_unit(const LevelView& level, const UnitSums& units, std::uint32_t neuron,
                                         std::uint32_t point) {
    atomicAdd(&units.sums[neuron].x, 1u);
    atomicAdd(&units.sums[neuron].y, point & 0xFFFFu);
    atomicAdd(&units.sums[neuron].z, point >> 16);
    const int row = neuron / level.lattice.columns, column = neuron % level.lattice.columns;
    atomicOr(&units.mask[row * level.words + column / 32], 1u << (column % 32));
}

// Returns the bits of the mask row for columns [first, first + 64); columns that do not exist give 0.
__device__ __forceinline__ std::uint64_t mask_window(const std::uint32_t* row, int words, int first) {
    const int word = first >> 5, shift = first & 31;  // first may be negative: arithmetic shift
    const auto at = [&](int w) { return w >= 0 && w < words ? __ldcg(&row[w]) : 0u; };
    const std::uint32_t a = at(word), b = at(word + 1), c = at(word + 2);
    return static_cast<std::uint64_t>(__funnelshift_r(b, c, shift)) << 32 | __funnelshift_r(a, b, shift);
}

inline constexpr int kUnitsAtOnce = 4;  // units that a lane loads before it waits

// The division of a warp's lanes among several iterations: each lane reads one row of the
// units of one iteration.
struct LaneSplit {
    int shift;  // log2 of the number of lanes per iteration
    __device__ int iterations() const { return 32 >> shift; }
    __device__ int rows() const { return 1 << shift; }
};

// Returns the division for as many iterations as possible, with one lane per row within the radius.
__device__ __forceinline__ LaneSplit split_lanes(int radius) {
    const int rows = kPatchRows + 2 * radius;
    return {rows <= 8 ? 3 : rows <= 16 ? 4 : 5};
}

// The work of one warp: the targets of a patch of neurons in `count` iterations, at most split.iterations().
struct TargetTask {
    int set, count;  // the first of the iterations' sets of units, which follow each other
    LaneSplit split;
    int2 patch;        // its column and row, in patches
    const int* radii;  // one per iteration
    const uint2 (*tables)[kTableWidth];
    uint4* scratch;  // 32 x kUnitsAtOnce units: axial q and row, and the sums
    step::Target (*targets)[32];
};

// Lists the units found by the lanes for which `mine` is true, and returns their number.
__device__ __forceinline__ int list_units(const uint4 (&found)[kUnitsAtOnce], bool mine, uint4* list,
                                          int lane) {
    int listed = 0;
    __syncwarp();
#pragma unroll
    for (int k = 0; k < kUnitsAtOnce; ++k) {
        const bool holds = mine && found[k].y != 0;
        const unsigned holders = __ballot_sync(kAllLanes, holds);
        if (holds) list[listed + __popc(holders & ((1u << lane) - 1))] = found[k];
        listed += __popc(holders);
    }
    __syncwarp();
    return listed;
}

// Writes the targets of a patch's neurons, each lane that of its neuron at (x, y). Each lane finds the units
// within the radius in one row of the mask and loads several of them at once; then all lanes add up the units
// of one iteration after the other.
__device__ __forceinline__ void find_targets(const LevelView& level, const TargetTask& task, int lane,
                                             float x, float y) {
    const int columns = level.lattice.columns, rows = level.lattice.rows;
    const int row = task.patch.y * kPatchRows + lane / kPatchColumns;
    const int q = step::axial_q(task.patch.x * kPatchColumns + lane % kPatchColumns, row);
    const int own = lane >> task.split.shift;  // the iteration whose units this lane loads
    const bool active = own < task.count;
    const int radius = active ? task.radii[own] : 0;
    const std::size_t first = static_cast<std::size_t>(task.set + own) * rows;
    const int window = task.patch.x * kPatchColumns - radius - 1, top = task.patch.y * kPatchRows;
    const int last_row = active ? min(rows, top + kPatchRows + radius) - 1 : -1;
    int unit_row = top - radius + (lane & (task.split.rows() - 1));
    const auto units_of_row = [&] {
        if (unit_row < 0 || unit_row > last_row) return std::uint64_t{0};
        // each row further off reaches half a column less on either side
        const int shift = max(max(top - unit_row, unit_row - (top + kPatchRows - 1)), 0) / 2;
        const std::uint64_t within = ~std::uint64_t{0} >> (64 - (kPatchColumns + 2 * radius + 2));
        return mask_window(level.units.mask + (first + unit_row) * level.words, level.words, window) &
               (within << shift) & (within >> shift);
    };
    std::uint64_t bits = units_of_row();
    uint4 found[kUnitsAtOnce];
    const auto fetch = [&] {
        if (!bits && unit_row + task.split.rows() <= last_row) {  // more rows than lanes
            unit_row += task.split.rows();
            bits = units_of_row();
        }
#pragma unroll
        for (int k = 0; k < kUnitsAtOnce; ++k) {
            found[k] = {};
            if (!bits) continue;
            const int unit_column = window + __ffsll(bits) - 1;
            bits &= bits - 1;
            const uint4 sums = __ldcg(&level.units.sums[(first + unit_row) * columns + unit_column]);
            const std::uint32_t unit_q =
                static_cast<std::uint32_t>(step::axial_q(unit_column, unit_row)) & 0xFFFFu;
            found[k] = {unit_q | static_cast<std::uint32_t>(unit_row) << 16, sums.x, sums.y, sums.z};
        }
    };
    fetch();
    for (int t = 0; t < task.count; ++t) {
        step::LearningSums sums;
        for (;;) {
            const int listed = list_units(found, own == t, task.scratch, lane);
#pragma unroll 4
            for (int k = 0; k < listed; ++k) accumulate_unit(task.scratch[k], task.tables[t], q, row, sums);
            const bool more = own == t && (bits || unit_row + task.split.rows() <= last_row);
            if (!__any_sync(kAllLanes, more)) break;
            if (own == t) fetch();
        }
        task.targets[t][lane] = step::target_of(sums, x, y);
    }
}

// Clears the units of a patch in `count` sets from `set` on. Each lane clears a row of the patch, so a warp
// clears eight sets at once.
__device__ __forceinline__ void clear_patch(const LevelView& level, int set, int count, int patch_column,
                                            int patch_row, int lane) {
    const int rows = level.lattice.rows, columns = level.lattice.columns;
    const int row = patch_row * kPatchRows + lane % kPatchRows;
    for (int k = lane / kPatchRows; k < count && row < rows; k += 32 / kPatchRows) {
        const std::size_t at = static_cast<std::size_t>(set + k) * rows + row;
        unsigned char* const byte =
            reinterpret_cast<unsigned char*>(level.units.mask + at * level.words) + patch_column;
        unsigned bits = __ldcg(byte);
        if (!bits) continue;
        *byte = 0;
        for (; bits; bits &= bits - 1)
            level.units.sums[at * columns + patch_column * kPatchColumns + __ffs(bits) - 1] = {};
    }
}

}  // namespace hexrelief::cuda
