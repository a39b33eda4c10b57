// Regions of pixels that hang together, found on words of 32 pixels of a row: bit b of a row's word k is its
// pixel 32 k + b.
#pragma once

#include <cstdint>

namespace hexrelief::cuda {

struct WordGrid {
    unsigned width, per_row, count;  // px, words, words
    __device__ unsigned row(unsigned word) const { return word / per_row; }
    __device__ unsigned first_pixel(unsigned word) const { return row(word) * width + 32 * (word % per_row); }
};

// A region's entry stands at its first run's first pixel + 1. 0 stands for all that are too large to be
// specks: they need not be told apart.
struct RegionArrays {
    unsigned* roots;  // pixels + 1, set where short runs begin
    unsigned* areas;
    unsigned* backgrounds;

    __device__ void begin(unsigned entry) const {
        roots[entry] = entry;
        areas[entry] = backgrounds[entry] = 0;
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
    // The lesser root stays one, so that it does not matter who comes first.
    __device__ void unite(unsigned a, unsigned b) const {
        for (a = root(a), b = root(b); a != b; a = root(a), b = root(b)) {
            const unsigned high = max(a, b), low = min(a, b);
            if (atomicCAS(&roots[high], high, low) == high) return;
        }
    }
};

// Runs are pixels of a word that hang together; `right` tells which hang together with the next on the
// right, bit 31 with the next word's first.
__device__ inline unsigned run_first(unsigned right, unsigned bit) {
    return 32 - __clz(~right & ((1u << bit) - 1));
}
__device__ inline unsigned run_end(unsigned right, unsigned bit) {
    const unsigned gaps = ~right >> bit;
    return gaps ? bit + __ffs(gaps) : 32;
}
__device__ inline unsigned run_starts(unsigned right) {
    return ~(right << 1);
}

// The pixels of runs of at least `least`.
__device__ inline unsigned long_runs(unsigned right, unsigned least) {
    if (least > 32) return 0;
    if (least < 2) return ~0u;
    unsigned first = right & 0x7fffffffu;  // where `have` + 1 pixels in a row hang together
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

// Regions of at least `least` pixels are large: two touching runs that have as many are put to them at once,
// which keeps all threads from meeting at one entry. right(word), down(word): which pixels hang together with
// those on the right and below. Entries of short runs, and 0, have begun.
template <typename Crew, typename Right, typename Down>
__device__ void join_regions(const Crew& crew, const WordGrid& grid, const RegionArrays& regions,
                             unsigned least, const Right& right, const Down& down) {
    const auto join = [&](unsigned first_a, unsigned right_a, unsigned bit_a, unsigned first_b,
                          unsigned right_b, unsigned bit_b) {
        const unsigned start_a = run_first(right_a, bit_a), start_b = run_first(right_b, bit_b);
        const unsigned size_a = run_end(right_a, bit_a) - start_a, size_b = run_end(right_b, bit_b) - start_b;
        const unsigned a = first_a + start_a + 1, b = first_b + start_b + 1;
        if (size_a + size_b < least) return regions.unite(a, b);
        if (size_a < least) regions.unite(a, 0);
        if (size_b < least) regions.unite(b, 0);
    };
    crew.each(grid.count, [&](unsigned word) {
        const unsigned own = right(word), first = grid.first_pixel(word), own_long = long_runs(own, least);
        if (word % grid.per_row > 0) {
            const unsigned left = right(word - 1);
            if (left >> 31 && !(own_long & long_runs(left, least) >> 31))
                join(first - 32, left, 31, first, own, 0);
        }
        if (word < grid.per_row) return;
        const unsigned above = right(word - grid.per_row);
        unsigned pairs = down(word - grid.per_row);
        if (!pairs) return;
        pairs &= ~(own_long & long_runs(above, least));
        pairs &= ~((pairs & own & above) << 1);  // one of each two runs
        for (; pairs; pairs &= pairs - 1) {
            const unsigned bit = __ffs(pairs) - 1;
            join(first - grid.width, above, bit, first, own, bit);
        }
    });
}

// Sums up the regions' pixels, and those of them in background(word). pixels(word): which take part.
template <typename Crew, typename Pixels, typename Right, typename Background>
__device__ void measure_regions(const Crew& crew, const WordGrid& grid, const RegionArrays& regions,
                                unsigned least, const Pixels& pixels, const Right& right,
                                const Background& background) {
    crew.each(grid.count, [&](unsigned word) {
        const unsigned own = right(word), first = grid.first_pixel(word);
        unsigned starts = pixels(word) & run_starts(own) & ~long_runs(own, least);
        for (; starts; starts &= starts - 1) {
            const unsigned bit = __ffs(starts) - 1, size = run_end(own, bit) - bit, entry = first + bit + 1,
                           root = regions.root(entry);
            if (root == 0) continue;
            atomicAdd(&regions.areas[root], size);
            const unsigned known = __popc((background(word) >> bit) & (~0u >> (32 - size)));
            if (known) atomicAdd(&regions.backgrounds[root], known);
        }
    });
}

// Of the word, the pixels of regions of which is_speck(area, background) tells that they are specks.
template <typename IsSpeck>
__device__ unsigned specks_of_word(const WordGrid& grid, const RegionArrays& regions, unsigned word,
                                   unsigned least, unsigned pixels, unsigned right, const IsSpeck& is_speck) {
    unsigned specks = 0;
    for (unsigned starts = pixels & run_starts(right) & ~long_runs(right, least); starts;
         starts &= starts - 1) {
        const unsigned bit = __ffs(starts) - 1, size = run_end(right, bit) - bit,
                       root = regions.root(grid.first_pixel(word) + bit + 1);
        if (root != 0 && is_speck(regions.areas[root], regions.backgrounds[root]))
            specks |= ~0u >> (32 - size) << bit;
    }
    return specks;
}

}  // namespace hexrelief::cuda
