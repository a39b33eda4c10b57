// The units of large levels: points that neurons won, summed per neuron in sets of their own for each
// iteration of a batch. Device functions that add to, read and clear them, each the work of a warp. Included
// by som.cu.
#pragma once

#include "cuda/som/search.cuh"

namespace hexrelief::cuda {

__device__ __forceinline__ void add_unit(const LevelView& level, const UnitSums& units, std::uint32_t neuron,
                                         std::uint32_t point) {
    atomicAdd(&units.sums[neuron].x, 1u);
    atomicAdd(&units.sums[neuron].y, point & 0xFFFFu);
    atomicAdd(&units.sums[neuron].z, point >> 16);
    const int row = neuron / level.lattice.columns, column = neuron % level.lattice.columns;
    atomicOr(&units.mask[row * level.words + column / 32], 1u << (column % 32));
}

// Bits of the mask row for columns [first, first + 64), as far as they exist.
__device__ __forceinline__ std::uint64_t mask_window(const std::uint32_t* row, int words, int first) {
    const int word = first >> 5, shift = first & 31;  // first may be negative: arithmetic shift
    const auto at = [&](int w) { return w >= 0 && w < words ? __ldcg(&row[w]) : 0u; };
    const std::uint32_t a = at(word), b = at(word + 1), c = at(word + 2);
    return static_cast<std::uint64_t>(__funnelshift_r(b, c, shift)) << 32 | __funnelshift_r(a, b, shift);
}

inline constexpr int kUnitsAtOnce = 4;  // that a lane asks for before it waits

// Several iterations that a warp works out together: a lane looks through one row of one of them.
struct Together {
    int shift;  // log2 of the lanes an iteration
    __device__ int iterations() const { return 32 >> shift; }
    __device__ int rows() const { return 1 << shift; }
};

// As many as the rows within the radius leave lanes for.
__device__ __forceinline__ Together together_within(int radius) {
    const int rows = kPatchRows + 2 * radius;
    return {rows <= 8 ? 3 : rows <= 16 ? 4 : 5};
}

// The targets of up to 32 >> shift iterations for a patch of neurons by one warp, a lane a neuron, which
// stands at (x, y): the lanes find the best matching units within reach in the mask (a lane a row), fetch
// them (several a lane at once), and all add up all of an iteration, one iteration after the other. The sets
// of the iterations follow each other from `set` on, and so do radius, tables and targets. `scratch` holds 32
// * kUnitsAtOnce units: q and row, and the sums.
__device__ __forceinline__ void find_targets(const LevelView& level, int set, int count, Together together,
                                             int patch_column, int patch_row, const int* radii,
                                             const uint2 (*tables)[kTableWidth], uint4* scratch, int lane,
                                             float x, float y, step::Target (*targets)[32]) {
    const int columns = level.lattice.columns, rows = level.lattice.rows;
    const int row = patch_row * kPatchRows + lane / kPatchColumns;
    const int q = step::axial_q(patch_column * kPatchColumns + lane % kPatchColumns, row);
    const int own = lane >> together.shift;  // the iteration that this lane looks for
    const bool looking = own < count;
    const int radius = looking ? radii[own] : 0;
    const std::size_t first = static_cast<std::size_t>(set + own) * rows;
    const int window = patch_column * kPatchColumns - radius - 1, top = patch_row * kPatchRows;
    const int last_row = looking ? min(rows, top + kPatchRows + radius) - 1 : -1;
    int unit_row = top - radius + (lane & (together.rows() - 1));
    const auto units_of_row = [&] {
        if (unit_row < 0 || unit_row > last_row) return std::uint64_t{0};
        // a row further off reaches half a column less far on either side
        const int shift = max(max(top - unit_row, unit_row - (top + kPatchRows - 1)), 0) / 2;
        const std::uint64_t within = ~std::uint64_t{0} >> (64 - (kPatchColumns + 2 * radius + 2));
        return mask_window(level.units.mask + (first + unit_row) * level.words, level.words, window) &
               (within << shift) & (within >> shift);
    };
    std::uint64_t bits = units_of_row();
    uint4 found[kUnitsAtOnce];
    const auto fetch = [&] {
        if (!bits && unit_row + together.rows() <= last_row) {  // more rows than lanes
            unit_row += together.rows();
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
    for (int t = 0; t < count; ++t) {
        step::Pull pull;
        for (;;) {
            int listed = 0;
            __syncwarp();
#pragma unroll
            for (int k = 0; k < kUnitsAtOnce; ++k) {
                const bool holds = own == t && found[k].y != 0;
                const unsigned holders = __ballot_sync(kAllLanes, holds);
                if (holds) scratch[listed + __popc(holders & ((1u << lane) - 1))] = found[k];
                listed += __popc(holders);
            }
            __syncwarp();
#pragma unroll 4
            for (int k = 0; k < listed; ++k) add_pull(scratch[k], tables[t], q, row, pull);
            const bool more = own == t && (bits || unit_row + together.rows() <= last_row);
            if (!__any_sync(kAllLanes, more)) break;
            if (own == t) fetch();
        }
        targets[t][lane] = step::target_of(pull, x, y);
    }
}

// Clears what `count` iterations left of a patch, whose sets follow each other from `set` on: a lane a row of
// the patch, so that a warp looks at eight iterations at once.
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
