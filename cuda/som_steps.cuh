// Device functions of one iteration, each the work of a warp or of a group of its lanes. Included by som.cu
// only. What other blocks write is read past L1 (__ldcg).
#pragma once

#include "cuda/level.h"
#include "mesher/steps/learning.h"
#include "mesher/steps/search.h"

namespace hexrelief::cuda {

inline constexpr unsigned kAllLanes = 0xFFFFFFFFu;

// A candidate as one integer: squared distances are non-negative, so their bits order like the numbers, and
// ties go to the lowest index.
__device__ __forceinline__ std::uint64_t candidate_key(float squared_distance, std::uint32_t neuron) {
    return static_cast<std::uint64_t>(__float_as_uint(squared_distance)) << 32 | neuron;
}

__device__ __forceinline__ float key_distance(std::uint64_t key) {
    return __uint_as_float(static_cast<std::uint32_t>(key >> 32));
}

template <int kLanes>
__device__ __forceinline__ std::uint64_t least_of_group(std::uint64_t key) {
#if __CUDA_ARCH__ >= 800
    constexpr bool kInHardware = kLanes == 32;
#else
    constexpr bool kInHardware = false;
#endif
    if constexpr (kInHardware) {  // two reductions instead of ten shuffles
#if __CUDA_ARCH__ >= 800
        const std::uint32_t high = static_cast<std::uint32_t>(key >> 32);
        const std::uint32_t least = __reduce_min_sync(kAllLanes, high);
        const std::uint32_t low = high == least ? static_cast<std::uint32_t>(key) : 0xFFFFFFFFu;
        key = static_cast<std::uint64_t>(least) << 32 | __reduce_min_sync(kAllLanes, low);
#endif
    } else {
        for (int step = kLanes / 2; step > 0; step /= 2) {
            const std::uint64_t other = __shfl_xor_sync(kAllLanes, key, step, kLanes);
            key = other < key ? other : key;
        }
    }
    return key;
}

// counts[cell] + 1 for every calling lane, and its place among those counted; lanes of one cell, which
// neighbouring neurons mostly are, count in one atomic. All lanes of the warp call; those with cell < 0 only
// take part.
__device__ __forceinline__ std::uint32_t count_in_cell(std::uint32_t* counts, int cell) {
    const unsigned same = __match_any_sync(kAllLanes, cell);
    const int lane = threadIdx.x % 32, leader = __ffs(same) - 1;
    std::uint32_t base = 0;
    if (lane == leader && cell >= 0)
        base = atomicAdd(&counts[cell], static_cast<std::uint32_t>(__popc(same)));
    return __shfl_sync(kAllLanes, base, leader) + __popc(same & ((1u << lane) - 1));
}

// A stretch of the neurons in the order of their cells.
struct Stretch {
    std::uint32_t begin, count;
};

__device__ __forceinline__ std::uint64_t measure_sorted(const LevelView& level, const float2* sorted,
                                                        std::uint32_t i, float px, float py) {
    const float2 at = __ldcg(&sorted[i]);
    const float dx = at.x - px, dy = at.y - py;
    return candidate_key(dx * dx + dy * dy, __ldcg(&level.ids[i]));
}

// step::spiral_search by a group of kLanes lanes. The own cell and ring 1 are stretches of three rows of
// cells, so that each takes one round of independent loads; rings further out are rarely reached, and go a
// lane a cell. Groups that are not active take part in the votes of their warp.
template <int kLanes>
__device__ __forceinline__ std::uint32_t search_by_group(const LevelView& level, const float2* sorted,
                                                         std::uint32_t point, bool active, int lane) {
    const step::CellGrid& grid = level.grid;
    const int hx = point & 0xFFFFu, hy = point >> 16;
    const float px = static_cast<float>(hx) * 0.5f, py = static_cast<float>(hy) * 0.5f;
    const int cx = __umulhi(hx, level.cell_factor), cy = __umulhi(hy, level.cell_factor),
              limit = step::ring_limit(grid, level.ssr);
    std::uint64_t best = candidate_key(step::Candidate{}.squared_distance, step::Candidate{}.neuron);

    const int cell = cy * grid.columns + cx;
    std::uint32_t own_begin = 0, own_end = 0;
    if (active) {
        own_begin = __ldcg(&level.begin[cell]);
        own_end = __ldcg(&level.end[cell]);
        for (std::uint32_t i = own_begin + lane; i < own_end; i += kLanes) {
            const std::uint64_t key = measure_sorted(level, sorted, i, px, py);
            best = key < best ? key : best;
        }
    }
    best = least_of_group<kLanes>(best);

    // ring 1: of the rows above and below the cells that the circle reaches, which are neighbours of the
    // middle one; of the own row those to the left and to the right
    float reach = key_distance(best);
    bool searching = active && !(step::ring_distance(grid, cx, cy, 1, px, py) > reach);
    if (__any_sync(kAllLanes, searching)) {
        Stretch stretch[4] = {};
        if (searching) {
            const bool west = cx > 0, east = cx + 1 < grid.columns;
            for (int side = 0; side < 2; ++side) {
                const int v = side ? cy + 1 : cy - 1;
                if (v < 0 || v >= grid.rows || step::cell_distance(grid, cx, v, px, py) > reach) continue;
                const int from =
                    west && !(step::cell_distance(grid, cx - 1, v, px, py) > reach) ? cx - 1 : cx;
                const int to = east && !(step::cell_distance(grid, cx + 1, v, px, py) > reach) ? cx + 1 : cx;
                stretch[side].begin = __ldcg(&level.begin[v * grid.columns + from]);
                stretch[side].count = __ldcg(&level.end[v * grid.columns + to]) - stretch[side].begin;
            }
            if (west && !(step::cell_distance(grid, cx - 1, cy, px, py) > reach)) {
                stretch[2].begin = __ldcg(&level.begin[cell - 1]);
                stretch[2].count = own_begin - stretch[2].begin;
            }
            if (east && !(step::cell_distance(grid, cx + 1, cy, px, py) > reach)) {
                stretch[3].begin = own_end;
                stretch[3].count = __ldcg(&level.end[cell + 1]) - own_end;
            }
        }
        const std::uint32_t upto0 = stretch[0].count, upto1 = upto0 + stretch[1].count,
                            upto2 = upto1 + stretch[2].count;
        const std::uint32_t total = upto2 + stretch[3].count;
        for (std::uint32_t k = lane; k < total; k += kLanes) {
            const std::uint32_t i = k < upto0   ? stretch[0].begin + k
                                    : k < upto1 ? stretch[1].begin + (k - upto0)
                                    : k < upto2 ? stretch[2].begin + (k - upto1)
                                                : stretch[3].begin + (k - upto2);
            const std::uint64_t key = measure_sorted(level, sorted, i, px, py);
            best = key < best ? key : best;
        }
        best = least_of_group<kLanes>(best);
    }

    for (int ring = 2;; ++ring) {
        reach = key_distance(best);
        searching = searching && ring <= limit && !(step::ring_distance(grid, cx, cy, ring, px, py) > reach);
        if (!__any_sync(kAllLanes, searching)) break;
        if (searching)
            for (int k = lane; k < 8 * ring;
                 k += kLanes) {  // a lane a cell of the ring: most are empty this far out
                int u, v;
                step::ring_cell(ring, k, u, v);
                u += cx;
                v += cy;
                if (u < 0 || u >= grid.columns || v < 0 || v >= grid.rows) continue;
                if (step::cell_distance(grid, u, v, px, py) > reach) continue;
                const std::uint32_t end = __ldcg(&level.end[v * grid.columns + u]);
                for (std::uint32_t i = __ldcg(&level.begin[v * grid.columns + u]); i < end; ++i) {
                    const std::uint64_t key = measure_sorted(level, sorted, i, px, py);
                    best = key < best ? key : best;
                }
            }
        best = least_of_group<kLanes>(best);
    }
    return static_cast<std::uint32_t>(best);
}

__device__ __forceinline__ void add_unit(const LevelView& level, const UnitSums& units, std::uint32_t neuron,
                                         std::uint32_t point) {
    atomicAdd(&units.sums[neuron].x, 1u);
    atomicAdd(&units.sums[neuron].y, point & 0xFFFFu);
    atomicAdd(&units.sums[neuron].z, point >> 16);
    const int row = neuron / level.lattice.columns, column = neuron % level.lattice.columns;
    atomicOr(&units.mask[row * level.words + column / 32], 1u << (column % 32));
}

inline constexpr int kPatchColumns = 8, kPatchRows = 4;  // neurons of one warp

// Bits of the mask row for columns [first, first + 64), as far as they exist.
__device__ __forceinline__ std::uint64_t mask_window(const std::uint32_t* row, int words, int first) {
    const int word = first >> 5, shift = first & 31;  // first may be negative: arithmetic shift
    const auto at = [&](int w) { return w >= 0 && w < words ? __ldcg(&row[w]) : 0u; };
    const std::uint32_t a = at(word), b = at(word + 1), c = at(word + 2);
    return static_cast<std::uint64_t>(__funnelshift_r(b, c, shift)) << 32 | __funnelshift_r(a, b, shift);
}

// A warp's own shared memory in the triggering step.
struct PatchScratch {
    static constexpr int kUnitsAtOnce = 4;  // that a lane asks for before it waits
    uint4 units[32 * kUnitsAtOnce];         // q, row, and the packed sums: see learn_patch
    uint2 tables[kTableWidth];              // gain and fall of each distance, 0 beyond the radius
};

// Adds one unit's pull on the neuron at axial (q, row).
__device__ __forceinline__ void add_pull(const uint4& unit, const uint2* tables, int q, int row,
                                         step::Pull& pull) {
    const int dq = static_cast<std::int16_t>(unit.x & 0xFFFFu) - q, dr = static_cast<int>(unit.x >> 16) - row;
    const int distance = max(max(abs(dq), abs(dr)), abs(dq + dr));
    const uint2 table = tables[min(distance, kTableWidth - 1)];
    pull.gain += table.x * unit.y;
    pull.x += table.x * unit.z;
    pull.y += table.x * unit.w;
    pull.fall += table.y * unit.y;
}

struct Positions {
    float *x, *y;
    float2* sorted;
};

// The triggering step of a patch of neurons by one warp, a lane each: the lanes find the best matching units
// within reach in the mask (a lane a row), fetch them (several a lane at once), and all add up all. Reads
// `units`, clears the patch in `clear`.
__device__ __forceinline__ void learn_patch(const LevelView& level, const UnitSums& units,
                                            const UnitSums& clear, const Positions& from, const Positions& to,
                                            int patch_column, int patch_row, int radius,
                                            PatchScratch& scratch, int lane) {
    const int columns = level.lattice.columns, rows = level.lattice.rows;
    const int column = patch_column * kPatchColumns + lane % kPatchColumns,
              row = patch_row * kPatchRows + lane / kPatchColumns;
    const bool inside = column < columns && row < rows;
    const int i = row * columns + column;
    float x = 0, y = 0;
    std::uint32_t place = 0;
    if (inside) {  // asked for early: the values are needed last
        x = __ldcg(&from.x[i]);
        y = __ldcg(&from.y[i]);
        place = __ldcg(&level.place[i]);
    }
    const int q = step::axial_q(column, row);
    const int window = patch_column * kPatchColumns - radius - 1;
    const std::uint64_t within = ~std::uint64_t{0} >> (64 - (kPatchColumns + 2 * radius + 2));
    const int first_row = max(0, patch_row * kPatchRows - radius);
    const int last_row = min(rows - 1, patch_row * kPatchRows + kPatchRows - 1 + radius);
    step::Pull pull;
    for (int r0 = first_row; r0 <= last_row; r0 += 32) {
        const int unit_row = r0 + lane;
        std::uint64_t bits =
            unit_row <= last_row
                ? mask_window(units.mask + unit_row * level.words, level.words, window) & within
                : 0;
        while (__any_sync(kAllLanes, bits != 0)) {
            uint4 found[PatchScratch::kUnitsAtOnce];
#pragma unroll
            for (int k = 0; k < PatchScratch::kUnitsAtOnce; ++k) {
                found[k] = {};
                if (!bits) continue;
                const int unit_column = window + __ffsll(bits) - 1;
                bits &= bits - 1;
                const uint4 sums = __ldcg(&units.sums[unit_row * columns + unit_column]);
                const std::uint32_t unit_q =
                    static_cast<std::uint32_t>(step::axial_q(unit_column, unit_row)) & 0xFFFFu;
                found[k] = {unit_q | static_cast<std::uint32_t>(unit_row) << 16, sums.x, sums.y, sums.z};
            }
            int count = 0;
            __syncwarp();
#pragma unroll
            for (int k = 0; k < PatchScratch::kUnitsAtOnce; ++k) {
                const unsigned holders = __ballot_sync(kAllLanes, found[k].y != 0);
                if (found[k].y) scratch.units[count + __popc(holders & ((1u << lane) - 1))] = found[k];
                count += __popc(holders);
            }
            __syncwarp();
#pragma unroll 4
            for (int k = 0; k < count; ++k) add_pull(scratch.units[k], scratch.tables, q, row, pull);
        }
    }
    if (!inside) return;
    if (pull.gain) {
        step::learn(pull, level.extent_x, level.extent_y, x, y);
        if (level.pinned)
            step::pin_to_border(level.lattice, column, row, level.extent_x, level.extent_y, x, y);
    }
    to.x[i] = x;
    to.y[i] = y;
    to.sorted[place] = {x, y};
    clear.sums[i] = {};
    if (column % 32 == 0) clear.mask[row * level.words + column / 32] = 0;
}

}  // namespace hexrelief::cuda
