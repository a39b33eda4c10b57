// Finds regions of connected pixels, on words of 32 pixels of a row.
#pragma once

#include <cstdint>

#include "cuda/common/grid.cuh"
#include "cuda/common/warp_reduce.cuh"
#include "cuda/surface/pixels/discontinuities.h"

namespace hexrelief::cuda {

// A union-find structure whose entry for a region is the first pixel of its first run + 1. Entry 0 stands for
// all regions that are too large to be speckles: they need not be distinguished.
struct Regions : RegionArrays {
    __device__ void begin(unsigned entry) const {
        roots[entry] = entry;
        areas[entry] = 0;
    }
    __device__ unsigned root(unsigned entry) const {
        volatile unsigned* const all = roots;
        for (unsigned parent = all[entry]; parent != entry;) {
            const unsigned next = all[parent];
            if (next != parent) all[entry] = next;
            entry = parent;
            parent = next;
        }
        return entry;
    }
    // Adds the entries' regions to the large ones.
    __device__ void enlarge(unsigned a, unsigned b) const {
        while (a != 0 || b != 0) {
            const unsigned above_a = a ? atomicExch(&roots[a], 0) : 0;
            const unsigned above_b = b ? atomicExch(&roots[b], 0) : 0;
            a = above_a == a ? 0 : above_a;
            b = above_b == b ? 0 : above_b;
        }
    }
    // Unites two regions. The lower root stays root, so that the order of threads does not matter. Both paths
    // are climbed at the same time.
    __device__ void unite(unsigned a, unsigned b) const {
        volatile unsigned* const all = roots;
        while (a != b) {
            unsigned above_a = all[a], above_b = all[b];
            while (above_a != above_b && (above_a != a || above_b != b)) {
                const unsigned next_a = all[above_a], next_b = all[above_b];
                if (next_a != above_a) all[a] = next_a;
                if (next_b != above_b) all[b] = next_b;
                a = above_a;
                b = above_b;
                above_a = next_a;
                above_b = next_b;
            }
            if (above_a == above_b) return;
            const unsigned high = max(a, b), low = min(a, b);
            if (atomicCAS(&roots[high], high, low) == high) return;
        }
    }
};

// A run is a sequence of connected pixels of a word. `right` says which pixels are connected with the next
// one on the right, bit 31 with the first pixel of the next word.
//
// Returns the first bit of the run that contains a bit.
__device__ inline unsigned run_first(unsigned right, unsigned bit) {
    return 32 - __clz(~right & ((1u << bit) - 1));
}
// Returns the end of the run that contains a bit.
__device__ inline unsigned run_end(unsigned right, unsigned bit) {
    const unsigned gaps = ~right >> bit;
    return gaps ? bit + __ffs(gaps) : 32;
}
// Returns the first bits of all runs.
__device__ inline unsigned run_starts(unsigned right) {
    return ~(right << 1);
}

// Returns the pixels of runs of at least `least` pixels.
__device__ inline unsigned long_runs(unsigned right, unsigned least) {
    if (least > 32) return 0;
    if (least < 2 || !(~right & 0x7fffffffu)) return ~0u;
    unsigned first = right & 0x7fffffffu;  // starts of `have` + 1 successive connected pixels
    for (unsigned have = 1; have < least - 1;) {
        const unsigned more = min(have, least - 1 - have);
        first &= first >> more;
        have += more;
    }
    for (unsigned have = 1; have < least;) {
        const unsigned more = min(have, least - have);
        first |= first << more;
        have += more;
    }
    return first;
}

// Returns the position of the word's bit that has `rank` set bits before it.
__device__ inline unsigned nth_bit(unsigned word, unsigned rank) {
    unsigned place = 0;
    HEXRELIEF_UNROLL
    for (unsigned half = 16; half > 0; half /= 2) {
        const unsigned lower = __popc(word & ((1u << half) - 1));
        if (rank < lower) continue;
        rank -= lower;
        word >>= half;
        place += half;
    }
    return place;
}

// Distributes the bits of the lanes' words over all lanes: calls visit(owner's lane, bit, whether there is
// one) by the whole warp.
template <typename Visit>
__device__ void deal_bits(unsigned word, unsigned lane, const Visit& visit) {
    const unsigned until = sum_up_to_lane(static_cast<unsigned>(__popc(word)));
    const unsigned all = __shfl_sync(~0u, until, 31);
    for (unsigned item = lane; item - lane < all; item += 32) {
        unsigned owner = 0;
        for (unsigned half = 16; half > 0; half /= 2)
            if (__shfl_sync(~0u, until, owner + half - 1) <= item) owner += half;
        const unsigned before = __shfl_sync(~0u, until, (owner + 31) % 32),
                       own = __shfl_sync(~0u, word, owner);
        visit(owner, nth_bit(own, owner > 0 ? item - before : item), item < all);
    }
}

// Calls visit(first, mine) for groups of words from `first` on, by whole warps, followed by a barrier. mine:
// true if the lane has word first + lane. If words are few, some lanes get none, so that all warps are busy.
template <typename Visit>
__device__ void each_word_group(const CooperativeGrid& grid, const WordGrid& words, const Visit& visit) {
    const unsigned warps = grid.warps(), rounds = (words.count + 32 * warps - 1) / (32 * warps),
                   size = (words.count + rounds * warps - 1) / (rounds * warps);
    for (unsigned first = grid.warp() * size; first < words.count; first += warps * size)
        visit(first, grid.lane() < size && first + grid.lane() < words.count);
    grid.wait();
}

// Joins connected runs to regions. Regions of at least `least` pixels are large; two touching runs that have
// as many together are marked large at once, which keeps the threads from contending for one entry.
// right(word), down(word): the pixels that are connected with the one on the right and below. Entries of
// short runs, and entry 0, must be initialised.
template <typename Right, typename Down>
__device__ void join_regions(const CooperativeGrid& grid, const Regions& regions, unsigned least,
                             const Right& right, const Down& down) {
    const WordGrid& words = regions.words;
    const auto join = [&](unsigned first_a, unsigned right_a, unsigned bit_a, unsigned first_b,
                          unsigned right_b, unsigned bit_b) {
        const unsigned start_a = run_first(right_a, bit_a), start_b = run_first(right_b, bit_b);
        const unsigned size_a = run_end(right_a, bit_a) - start_a, size_b = run_end(right_b, bit_b) - start_b;
        const unsigned a = first_a + start_a + 1, b = first_b + start_b + 1;
        if (size_a + size_b < least)
            regions.unite(a, b);
        else
            regions.enlarge(size_a < least ? a : 0, size_b < least ? b : 0);
    };
    each_word_group(grid, words, [&](unsigned first_word, bool mine) {
        const unsigned lane = grid.lane(), word = first_word + lane, row = mine ? word / words.per_row : 0,
                       column = word - row * words.per_row, first = row * words.width + 32 * column;
        unsigned own = 0, above = 0, pairs = 0;
        if (mine) {
            own = right(word);
            const unsigned left = column > 0 ? right(word - 1) : 0;
            if (row > 0) {
                above = right(word - words.per_row);
                pairs = down(word - words.per_row);
            }
            const unsigned own_long = long_runs(own, least);
            if (left >> 31 && !(own_long & long_runs(left, least) >> 31))
                join(first - 32, left, 31, first, own, 0);
            if (pairs) {
                pairs &= ~(own_long & long_runs(above, least));
                pairs &= ~((pairs & own & above) << 1);  // one of each two runs
            }
        }
        __syncwarp();
        deal_bits(pairs, lane, [&](unsigned owner, unsigned bit, bool is_one) {
            const unsigned its_own = __shfl_sync(~0u, own, owner), its_above = __shfl_sync(~0u, above, owner),
                           its_first = __shfl_sync(~0u, first, owner);
            if (is_one) join(its_first - words.width, its_above, bit, its_first, its_own, bit);
            __syncwarp();
        });
    });
}

// Adds up the regions' pixels. pixels(word): the pixels that take part.
template <typename Pixels, typename Right>
__device__ void measure_regions(const CooperativeGrid& grid, const Regions& regions, unsigned least,
                                const Pixels& pixels, const Right& right) {
    const WordGrid& words = regions.words;
    each_word_group(grid, words, [&](unsigned first_word, bool mine) {
        const unsigned lane = grid.lane(), own = mine ? right(first_word + lane) : 0,
                       starts =
                           mine ? pixels(first_word + lane) & run_starts(own) & ~long_runs(own, least) : 0;
        deal_bits(starts, lane, [&](unsigned owner, unsigned bit, bool is_one) {
            const unsigned its_own = __shfl_sync(~0u, own, owner);
            if (is_one) {
                const unsigned root = regions.root(words.first_pixel(first_word + owner) + bit + 1);
                if (root != 0) atomicAdd(&regions.areas[root], run_end(its_own, bit) - bit);
            }
            __syncwarp();
        });
    });
}

// Calls take(word, speckles) for each word, with its pixels in regions of fewer than `least` pixels.
template <typename Pixels, typename Right, typename Take>
__device__ void find_speckles(const CooperativeGrid& grid, const Regions& regions, unsigned least,
                              const Pixels& pixels, const Right& right, const Take& take) {
    const WordGrid& words = regions.words;
    __shared__ unsigned speckles_of_words[kGridWarps][32];  // per warp and lane
    unsigned* const speckles = speckles_of_words[threadIdx.x / 32];
    each_word_group(grid, words, [&](unsigned first_word, bool mine) {
        const unsigned lane = grid.lane(), own = mine ? right(first_word + lane) : 0,
                       starts =
                           mine ? pixels(first_word + lane) & run_starts(own) & ~long_runs(own, least) : 0;
        speckles[lane] = 0;
        __syncwarp();
        deal_bits(starts, lane, [&](unsigned owner, unsigned bit, bool is_one) {
            const unsigned its_own = __shfl_sync(~0u, own, owner);
            if (is_one) {
                const unsigned root = regions.root(words.first_pixel(first_word + owner) + bit + 1);
                if (root != 0 && regions.areas[root] < least)
                    atomicOr(&speckles[owner], ~0u >> (32 - (run_end(its_own, bit) - bit)) << bit);
            }
            __syncwarp();
        });
        if (mine) take(first_word + lane, speckles[lane]);
        __syncwarp();
    });
}

}  // namespace hexrelief::cuda
