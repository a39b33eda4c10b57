// Which neighbouring pixels lie on one surface, as find_surfaces() does it on the CPU.
#pragma once

#include <cfloat>
#include <cmath>
#include <cstdint>

#include "cuda/sheet_crew.cuh"
#include "cuda/sheet_regions.cuh"
#include "cuda/sheet_specks.cuh"
#include "cuda/sheet_state.cuh"
#include "mesher/steps/jumps.h"

namespace hexrelief::cuda {

// Disparities without background, the words of what is left open, and the map's quantum.
template <typename Crew>
__device__ void clean_pixels(const Crew& crew, const SheetState& s, const PixelArrays& a, unsigned least) {
    const int width = s.sizes.width, height = s.sizes.height;
    const unsigned lane = crew.lane(), unit = 1u << lane;
    unsigned quantum = __float_as_uint(1.0f);
    for (unsigned patch = crew.thread() / 32; patch < a.patches; patch += crew.threads() / 32) {
        const unsigned column = patch % a.words.per_row, row = patch / a.words.per_row * kPatchRows;
        const int x = static_cast<int>(32 * column + lane);
        float own[kPatchRows], next[kPatchRows];
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kPatchRows; ++k) {
            const int y = static_cast<int>(row + k);
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            own[k] = x < width && y < height ? s.pixels.map[i] : 0.0f;
            next[k] = lane == 31 && x + 1 < width && y < height ? s.pixels.map[i + 1] : 0.0f;
        }
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kPatchRows; ++k) {
            const int y = static_cast<int>(row + k);
            const bool inside = x < width && y < height;
            const float d = step::foreground(own[k], s.settings.background_px);
            const float beside = __shfl_down_sync(~0u, d, 1),
                        right = lane == 31 ? step::foreground(next[k], s.settings.background_px) : beside;
            if (step::shows_quantum(d, right))
                quantum = min(quantum, __float_as_uint(step::distance(d, right)));
            const bool is_empty = inside && !(d > 0);
            const unsigned empty = __ballot_sync(~0u, is_empty);
            const unsigned background = __ballot_sync(~0u, is_empty && step::is_known(own[k]) && own[k] > 0);
            if (inside) s.pixels.disparity[static_cast<std::size_t>(y) * width + x] = d;
            if (y >= height) continue;
            const unsigned word = static_cast<unsigned>(y) * a.words.per_row + column;
            if (lane == 0) {
                a.empty[word] = empty;
                a.background[word] = background;
            }
            const unsigned runs = empty & (empty >> 1);
            if (empty & run_starts(runs) & ~long_runs(runs, least) & unit)
                a.regions.begin(static_cast<unsigned>(y) * width + x + 1);
        }
    }
    for (unsigned across = 16; across > 0; across /= 2)
        quantum = min(quantum, __shfl_xor_sync(~0u, quantum, across));
    volatile unsigned* const known = &a.counts->quantum_bits;
    if (lane == 0 && quantum < *known) atomicMin(&a.counts->quantum_bits, quantum);
    crew.wait();
}

// What the lanes of a warp hand to each other while they look at a patch.
struct PatchScratch {
    unsigned jumps[2 * kPatchRows];  // right and down, a word for each row
    std::uint8_t steps[64 * kPatchRows];
};

__device__ inline PatchScratch& own_scratch() {
    __shared__ PatchScratch scratch[32];
    return scratch[threadIdx.x / 32];
}

// Where d[0] .. d[kPatchRows] are the lane's column of the patch, its steps: a bit for each row's right and
// lower one.
__device__ inline unsigned find_steps(const float* d, const float* beyond, int x, int y0, int width,
                                      int height, unsigned lane, float least_px) {
    unsigned steps = 0;
    HEXRELIEF_UNROLL
    for (int k = 0; k < static_cast<int>(kPatchRows); ++k) {
        const float beside = __shfl_down_sync(~0u, d[k], 1);
        const float right = x + 1 >= width ? d[k] : lane == 31 ? beyond[k] : beside;
        const float below = y0 + k + 1 < height ? d[k + 1] : d[k];
        steps |= static_cast<unsigned>(step::steps_at(d[k], right, below, least_px)) << (2 * k);
    }
    return steps;
}

// The jumps of a patch's pixels and all that follows from them; the first time, regions begin as well.
__device__ inline void find_jumps(const SheetState& s, const PixelArrays& a, unsigned patch, unsigned lane,
                                  float jump_px, unsigned least, bool first) {
    constexpr int kRows = static_cast<int>(kPatchRows);
    const int width = s.sizes.width, height = s.sizes.height;
    const float least_px = s.settings.bridge ? HUGE_VALF : jump_px;
    const bool shifted = s.pixels.color && s.settings.color_shift_px > 0;
    const float* const disparity = s.pixels.disparity;
    const unsigned column = patch % a.words.per_row, row = patch / a.words.per_row;
    const int x0 = static_cast<int>(32 * column), x = x0 + static_cast<int>(lane),
              y0 = static_cast<int>(row * kPatchRows);
    const auto pixel = [&](int u, int v) { return static_cast<std::size_t>(v) * width + u; };
    float d[kRows + 1], beyond[kRows];
    unsigned taken[kRows];
    HEXRELIEF_UNROLL
    for (int k = 0; k <= kRows; ++k) d[k] = x < width && y0 + k < height ? disparity[pixel(x, y0 + k)] : 0.0f;
    HEXRELIEF_UNROLL
    for (int k = 0; k < kRows; ++k) {
        const bool inside = y0 + k < height;
        beyond[k] = lane == 31 && x + 1 < width && inside ? disparity[pixel(x + 1, y0 + k)] : 0.0f;
        taken[k] = inside ? a.absorbed[(y0 + k) * a.words.per_row + column] : 0;
    }
    const unsigned steps = find_steps(d, beyond, x, y0, width, height, lane, least_px);

    // Steps are few: the warp makes a list of them, so that all lanes have one to judge.
    PatchScratch& scratch = own_scratch();
    unsigned count = 0;
    HEXRELIEF_UNROLL
    for (unsigned k = 0; k < 2 * kPatchRows; ++k) {
        const unsigned word = __ballot_sync(~0u, steps >> k & 1);
        if (lane == k) scratch.jumps[k] = word;
        if (steps >> k & 1)
            scratch.steps[count + __popc(word & ((1u << lane) - 1))] =
                static_cast<std::uint8_t>(32 * k + lane);
        count += __popc(word);
    }
    if (shifted && x < width)
        for (int y = y0; y < min(height, y0 + kRows); ++y)
            reinterpret_cast<char2*>(s.pixels.shifts)[pixel(x, y)] = {0, 0};
    __syncwarp();
    for (unsigned k = lane; k < count; k += 32) {
        const unsigned own = scratch.steps[k], bit = own % 32;
        const step::Crack crack{x0 + static_cast<int>(bit), y0 + static_cast<int>(own / 64),
                                static_cast<int>(own / 32 % 2)};
        const std::size_t i = pixel(crack.x, crack.y);
        if (!step::is_jump_of_step(disparity + i, crack, width, height, least_px))
            atomicAnd(&scratch.jumps[own / 32], ~(1u << bit));
        else if (shifted)
            s.pixels.shifts[2 * i + crack.down] = step::shift_at(s.pixels.color, s.pixels.channels, crack,
                                                                 width, height, s.settings.color_shift_px);
    }
    __syncwarp();

    const unsigned left = static_cast<unsigned>(width - x0), within = left < 32 ? (1u << left) - 1 : ~0u,
                   before_last = left > 32 ? ~0u : within >> 1;
    unsigned crowded = 0;  // pixels with jumps
    HEXRELIEF_UNROLL
    for (int k = 0; k < kRows; ++k) {
        const int y = y0 + k;
        if (y >= height) break;
        const unsigned right = scratch.jumps[2 * k], down = scratch.jumps[2 * k + 1];
        crowded += (right | down) >> lane & 1;
        if (x < width)
            s.pixels.flags[pixel(x, y)] = static_cast<std::uint8_t>(
                (right >> lane & 1 ? step::kJumpRight : 0) | (down >> lane & 1 ? step::kJumpDown : 0) |
                (taken[k] >> lane & 1 ? 0 : step::kTrusted));
        if (!first) continue;
        const unsigned open = before_last & ~right;
        if (lane == 0) {
            a.right[y * a.words.per_row + column] = open;
            a.down[y * a.words.per_row + column] = y + 1 < height ? within & ~down : 0;
        }
        if ((within & run_starts(open) & ~long_runs(open, least)) >> lane & 1)
            a.regions.begin(static_cast<unsigned>(pixel(x, y)) + 1);
    }
    if (first && lane == 0) a.is_stale[patch] = 0;
    crowded += __shfl_xor_sync(~0u, crowded, 1);
    crowded += __shfl_xor_sync(~0u, crowded, 2);
    static_assert(step::kTile_px == 4 && kPatchRows == 4);
    if (lane % 4 == 0 && x < width)
        s.pixels.tile_sums[(row + 1) * step::tile_sum_count(width) + x / step::kTile_px + 1] = crowded;
    float nearest = 0, farthest = FLT_MAX;
    HEXRELIEF_UNROLL
    for (int k = 0; k < kRows; ++k) {
        nearest = step::max_of(nearest, d[k]);
        if (d[k] > 0) farthest = step::min_of(farthest, d[k]);
    }
    for (unsigned across = 16; across > 0; across /= 2) {
        nearest = step::max_of(nearest, __shfl_xor_sync(~0u, nearest, across));
        farthest = step::min_of(farthest, __shfl_xor_sync(~0u, farthest, across));
    }
    if (lane == 0) {
        a.nearest[patch] = nearest;
        a.farthest[patch] = farthest;
    }
}

// One warp makes running sums of `count` numbers, `stride` apart.
__device__ inline void sum_line(std::uint32_t* numbers, unsigned stride, unsigned count, unsigned lane) {
    constexpr unsigned kAtOnce = 4;
    unsigned before = 0;
    for (unsigned start = 0; start < count; start += 32 * kAtOnce) {
        unsigned own[kAtOnce];
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kAtOnce; ++k) {
            const unsigned i = start + 32 * k + lane;
            own[k] = i < count ? numbers[std::size_t{i} * stride] : 0;
        }
        HEXRELIEF_UNROLL
        for (unsigned k = 0; k < kAtOnce; ++k) {
            for (unsigned across = 1; across < 32; across *= 2) {
                const unsigned other = __shfl_up_sync(~0u, own[k], across);
                if (lane >= across) own[k] += other;
            }
            own[k] += before;
            before = __shfl_sync(~0u, own[k], 31);
            const unsigned i = start + 32 * k + lane;
            if (i < count) numbers[std::size_t{i} * stride] = own[k];
        }
    }
}

template <typename Crew>
__device__ void find_surfaces(Crew& crew, const SheetState& s, const PixelArrays& a) {
    const int width = s.sizes.width, height = s.sizes.height;
    PixelCounts& counts = *a.counts;
    if (crew.thread() == 0) {
        counts = {};
        counts.quantum_bits = __float_as_uint(1.0f);
        a.regions.begin(0);
        s.totals->nearest_px = 0;
        s.totals->farthest_px = FLT_MAX;
    }
    crew.wait();

    // Holes first: surfaces that they have torn to specks hang together again.
    const double cell_px = s.settings.cell_px;
    const unsigned least_hole =
        static_cast<unsigned>(step::clamp_to(std::ceil(step::kHoleShare * cell_px), 1.0, 1e9));
    clean_pixels(crew, s, a, least_hole);
    const float jump_px = s.settings.max_jump_px > 0
                              ? s.settings.max_jump_px
                              : step::jump_of_quantum(__uint_as_float(counts.quantum_bits));
    if (crew.thread() == 0) s.totals->jump_px = jump_px;
    const auto empty = [&](unsigned word) { return a.empty[word]; };
    const auto empty_right = [&](unsigned word) {
        const unsigned own = a.empty[word], next = (word + 1) % a.words.per_row > 0 ? a.empty[word + 1] : 0;
        return own & (own >> 1 | next << 31);
    };
    join_regions(crew, a.words, a.regions, least_hole, empty_right,
                 [&](unsigned word) { return a.empty[word] & a.empty[word + a.words.per_row]; });
    measure_regions(crew, a.words, a.regions, least_hole, empty, empty_right,
                    [&](unsigned word) { return a.background[word]; });
    const auto list = [&](unsigned word, unsigned specks, PixelCounts::Specks& found) {
        a.specks[word] = specks;
        a.deep[word] = 0;
        if (!specks) return;
        atomicAdd(&found.pixels, __popc(specks));
        a.speck_words[atomicAdd(&found.words, 1)] = word;
    };
    crew.each(a.words.count, [&](unsigned word) {
        const unsigned specks = specks_of_word(
            a.words, a.regions, word, least_hole, empty(word), empty_right(word),
            [&](unsigned area, unsigned background) {
                return step::is_small_hole(static_cast<int>(area), static_cast<int>(background), cell_px);
            });
        a.absorbed[word] = specks;
        list(word, specks, counts.holes);
    });
    absorb_specks(crew, s, a, &counts.holes);

    const unsigned least_region = static_cast<unsigned>(step::least_region_px(cell_px));
    crew.each_by_warp(a.patches, [&](unsigned patch, unsigned lane) {
        find_jumps(s, a, patch, lane, jump_px, least_region, true);
    });
    const auto all = [&](unsigned word) {
        const unsigned left = a.words.width - 32 * (word % a.words.per_row);
        return left < 32 ? (1u << left) - 1 : ~0u;
    };
    const auto right = [&](unsigned word) { return a.right[word]; };
    join_regions(crew, a.words, a.regions, least_region, right, [&](unsigned word) { return a.down[word]; });
    measure_regions(crew, a.words, a.regions, least_region, all, right, [](unsigned) { return 0u; });
    crew.each(a.words.count, [&](unsigned word) {
        const unsigned specks = specks_of_word(a.words, a.regions, word, least_region, all(word), right(word),
                                               [&](unsigned area, unsigned) { return area < least_region; });
        list(word, specks, counts.specks);
        if (!specks) return;
        a.absorbed[word] |= specks;
        mark_stale(a, word, specks, height, &counts.patches);
    });
    absorb_specks(crew, s, a, &counts.specks);
    crew.each_by_warp(counts.patches, [&](unsigned k, unsigned lane) {
        find_jumps(s, a, a.stale_patches[k], lane, jump_px, least_region, false);
    });

    float nearest = 0, farthest = FLT_MAX;
    for (unsigned patch = crew.thread(); patch < a.patches; patch += crew.threads()) {
        nearest = step::max_of(nearest, a.nearest[patch]);
        farthest = step::min_of(farthest, a.farthest[patch]);
    }
    for (unsigned across = 16; across > 0; across /= 2) {
        nearest = step::max_of(nearest, __shfl_xor_sync(~0u, nearest, across));
        farthest = step::min_of(farthest, __shfl_xor_sync(~0u, farthest, across));
    }
    if (crew.lane() == 0 && nearest > 0) {  // floats above 0 are ordered as their bits
        atomicMax(reinterpret_cast<unsigned*>(&s.totals->nearest_px), __float_as_uint(nearest));
        atomicMin(reinterpret_cast<unsigned*>(&s.totals->farthest_px), __float_as_uint(farthest));
    }
    const unsigned columns = step::tile_sum_count(width), rows = step::tile_sum_count(height);
    crew.each_by_warp(rows, [&](unsigned row, unsigned lane) {
        std::uint32_t* const sums = s.pixels.tile_sums + std::size_t{row} * columns;
        if (row == 0)
            for (unsigned i = lane; i < columns; i += 32) sums[i] = 0;
        else
            sum_line(sums + 1, 1, columns - 1, lane);
        if (lane == 0) sums[0] = 0;
    });
    crew.each_by_warp(columns - 1, [&](unsigned column, unsigned lane) {
        sum_line(s.pixels.tile_sums + columns + column + 1, columns, rows - 1, lane);
    });
}

}  // namespace hexrelief::cuda
