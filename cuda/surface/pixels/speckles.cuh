// Merges small regions of the disparity map into their surroundings.
#pragma once

#include "cuda/common/grid.cuh"
#include "cuda/surface/pixels/regions.cuh"

namespace hexrelief::cuda {

// Absorbs the pixels of speckles that are far from all others, ring by ring, until none is left.
__device__ inline void absorb_deep_pixels(CooperativeGrid& grid, const SurfaceState& s, const PixelArrays& a,
                                          unsigned words, step::Around kind) {
    const int width = s.sizes.width, height = s.sizes.height;
    for (bool left = true; left;) {
        grid.each_by_warp(words, [&](unsigned k, unsigned lane) {
            const unsigned word = a.deep_words[k];
            const int x = static_cast<int>(32 * (word % a.words.per_row) + lane),
                      y = static_cast<int>(a.words.row(word));
            float found = step::nothing(kind);
            const auto look_at = [&](int u, int v) {
                if (u < 0 || v < 0 || u >= width || v >= height) return;
                if (a.deep[v * a.words.per_row + u / 32] >> (u % 32) & 1) return;
                found = step::taken(found, s.pixels.disparity[static_cast<std::size_t>(v) * width + u], kind);
            };
            if (a.deep[word] >> lane & 1) {
                look_at(x - 1, y);
                look_at(x + 1, y);
                look_at(x, y - 1);
                look_at(x, y + 1);
            }
            const bool is_found = found != step::nothing(kind);
            const unsigned settled = __ballot_sync(~0u, is_found);
            // No lane reads it before the next round, because it still counts as deep until then.
            if (is_found) s.pixels.disparity[static_cast<std::size_t>(y) * width + x] = found;
            if (lane == 0) a.settled[word] = settled;
        });
        bool mine = false;
        for (unsigned k = grid.thread(); k < words; k += grid.threads()) {
            const unsigned word = a.deep_words[k];
            mine |= (a.deep[word] &= ~a.settled[word]) != 0;
        }
        left = grid.any(mine);
    }
}

// Lists the patches whose discontinuities may change with the word's speckles; each lane checks one patch.
__device__ inline void mark_stale(const PixelArrays& a, unsigned word, unsigned speckles, int height,
                                  unsigned lane, unsigned* count) {
    constexpr int kRows = static_cast<int>(kPatchRows);
    const int y = static_cast<int>(a.words.row(word)), middle = y / kRows,
              first = step::max_of(0, y - step::kDiscontinuitiesAbove_px) / kRows,
              last = step::min_of(height - 1, y + step::kDiscontinuitiesBelow_px) / kRows,
              rows = last - first + 1;
    int column = static_cast<int>(word % a.words.per_row), row = first + static_cast<int>(lane);
    if (row == last + 1 || row == last + 2) {
        const bool is_left = row == last + 1;
        const unsigned reach = is_left ? (1u << step::kDiscontinuitiesLeft_px) - 1
                                       : ~0u << (32 - step::kDiscontinuitiesRight_px);
        if (!(speckles & reach)) return;
        column += is_left ? -1 : 1;
        row = middle;
    }
    if (static_cast<int>(lane) >= rows + 2 || column < 0 || column >= static_cast<int>(a.words.per_row))
        return;
    const unsigned patch = row * a.words.per_row + column;
    if (atomicExch(&a.is_stale[patch], 1) == 0) a.stale_patches[atomicAdd(count, 1)] = patch;
}

// Returns the disparity taken from the four pixels at (at.x + across, at.y + down) and a quarter, half and
// three quarter turn from there, not counting speckles; step::nothing() if all four are. The four loads do
// not wait for each other.
__device__ inline float taken_of_four(const SurfaceState& s, const PixelArrays& a, const step::Pixel& at,
                                      int across, int down, step::Around kind) {
    unsigned i[4];
    bool counts[4];
    HEXRELIEF_UNROLL
    for (int k = 0; k < 4; ++k) {
        const int u = at.x + (k == 0   ? across
                              : k == 1 ? -down
                              : k == 2 ? -across
                                       : down),
                  v = at.y + (k == 0   ? down
                              : k == 1 ? across
                              : k == 2 ? -down
                                       : -across);
        counts[k] = u >= 0 && v >= 0 && u < s.sizes.width && v < s.sizes.height;
        i[k] = counts[k] ? static_cast<unsigned>(v * s.sizes.width + u) : 0;
        const unsigned word = counts[k] ? v * a.words.per_row + u / 32 : 0;
        counts[k] = counts[k] && !(a.speckles[word] >> (u & 31) & 1);
    }
    float found = step::nothing(kind);
    HEXRELIEF_UNROLL
    for (int k = 0; k < 4; ++k) {
        const float d = s.pixels.disparity[i[k]];
        if (counts[k]) found = step::taken(found, d, kind);
    }
    return found;
}

// Reach in rows plus columns; pixels that are farther from all others are absorbed ring by ring.
inline constexpr int kNearReach_px = 12;

// Gives each pixel of the listed words' speckles, or holes, a disparity of the nearest pixels outside them:
// the result of absorbing rings from the border inwards. stale: counts the listed patches whose
// discontinuities may change; null = they are not listed.
__device__ inline void absorb_speckles(CooperativeGrid& grid, const SurfaceState& s, const PixelArrays& a,
                                       PixelCounts::Speckles* counts, unsigned* stale, step::Around kind) {
    const bool all = counts->pixels == s.sizes.pixels();  // there is nothing to take it from
    const int width = s.sizes.width, height = s.sizes.height;
    grid.each_by_warp(counts->words, [&](unsigned k, unsigned lane) {
        const unsigned word = a.speckle_words[k], speckles = a.speckles[word];
        const int x = static_cast<int>(32 * (word % a.words.per_row) + lane),
                  y = static_cast<int>(a.words.row(word));
        if (stale) mark_stale(a, word, speckles, height, lane, stale);
        __syncwarp();
        const bool own = (speckles >> lane & 1) && !all;
        const float nothing = step::nothing(kind);
        float found = nothing;
        for (int reach = 1; own && found == nothing && reach <= kNearReach_px; ++reach)
            for (int down = 0; down < reach; ++down)
                found = step::taken(found, taken_of_four(s, a, {x, y}, reach - down, down, kind), kind);
        if (found != nothing) s.pixels.disparity[static_cast<std::size_t>(y) * width + x] = found;
        const unsigned deep = __ballot_sync(~0u, own && found == nothing);
        if (lane == 0 && deep) {
            a.deep[word] = deep;
            a.deep_words[atomicAdd(&counts->deep_words, 1)] = word;
        }
    });
    if (const unsigned deep = counts->deep_words) absorb_deep_pixels(grid, s, a, deep, kind);
}

}  // namespace hexrelief::cuda
