// The cellular matrix over one level's image: layout, activation and extraction of points (paper, section 4).
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/host_device.h"

namespace hexrelief::step {

// Cells of co x co pixels, row-major; the last column and row may be smaller.
struct CellGrid {
    int width, height;  // px of the level's image
    int co;             // side of a cell, px
    int columns, rows;  // ceil(width / co) x ceil(height / co)
};

HEXRELIEF_HD CellGrid make_cell_grid(int width, int height, int co) {
    return {width, height, co, (width + co - 1) / co, (height + co - 1) / co};
}

struct CellBox {
    int x0, y0, width, height;
    std::size_t offset;  // of the cell's first pixel in an array that keeps each cell's pixels together
};

HEXRELIEF_HD CellBox cell_box(const CellGrid& grid, int cell) {
    const int x0 = cell % grid.columns * grid.co, y0 = cell / grid.columns * grid.co;
    const int w = min_of(grid.co, grid.width - x0), h = min_of(grid.co, grid.height - y0);
    return {x0, y0, w, h, static_cast<std::size_t>(y0) * grid.width + static_cast<std::size_t>(x0) * h};
}

// The cell that a position lies in; positions on or beyond the image's border belong to the nearest cell.
HEXRELIEF_HD int cell_of(const CellGrid& grid, float x, float y) {
    const int cx = clamp_to(static_cast<int>(x / static_cast<float>(grid.co)), 0, grid.columns - 1);
    const int cy = clamp_to(static_cast<int>(y / static_cast<float>(grid.co)), 0, grid.rows - 1);
    return cy * grid.columns + cx;
}

// Bits of a quantised pixel weight such that a cell's sum stays below 2^32.
HEXRELIEF_HD int weight_bits(int co) {
    int bits = 24;
    while (bits > 1 &&
           (static_cast<std::uint64_t>(co) * static_cast<std::uint64_t>(co) << bits) > 0xFFFFFFFFull)
        --bits;
    return bits;
}

HEXRELIEF_HD std::uint32_t quantise_weight(float density, float scale) {
    return static_cast<std::uint32_t>(density * scale + 0.5f);
}

// Writes the cell's cumulative distribution, which is its local roulette wheel (Eq. 7): the inclusive prefix
// sums of its quantised weights in raster order. Returns the cell's sum.
HEXRELIEF_HD std::uint32_t cumulate_weights(const CellGrid& grid, int cell, const float* density, float scale,
                                            std::uint32_t* cumulative) {
    const CellBox box = cell_box(grid, cell);
    std::uint32_t sum = 0;
    std::size_t out = box.offset;
    for (int y = box.y0; y < box.y0 + box.height; ++y)
        for (int x = box.x0; x < box.x0 + box.width; ++x)
            cumulative[out++] = sum +=
                quantise_weight(density[static_cast<std::size_t>(y) * grid.width + x], scale);
    return sum;
}

// Eq. 6 as 32.32 fixed point: the expected number of points that the cell extracts in an iteration. Up to 1
// it is the activation probability; delta above 1 lets dense cells extract several points.
HEXRELIEF_HD std::uint64_t cell_activity(std::uint32_t cell_sum, std::uint32_t largest_sum, double delta) {
    return static_cast<std::uint64_t>(static_cast<double>(cell_sum) / static_cast<double>(largest_sum) *
                                      delta * 4294967296.0);
}

// The number of points that the cell extracts in this iteration: floor(activity + uniform), which is 0 or 1
// where delta <= 1.
HEXRELIEF_HD int draw_count(std::uint64_t activity, std::uint32_t uniform) {
    return static_cast<int>((activity + uniform) >> 32);
}

// A point in half pixels, so that pixel centres are integers: x = 2 * column + 1.
struct HalfPoint {
    int x, y;
};

// Draw k of n of a cell in an iteration, by 32 random bits.
struct Draw {
    int k, n;
    std::uint32_t uniform;
};

// The point of a draw from the cell's cumulative distribution (Eq. 7), found by binary search. The n draws
// are stratified: draw k falls into the k-th n-th of the distribution.
HEXRELIEF_HD HalfPoint extract_point(const CellGrid& grid, int cell, const std::uint32_t* cumulative,
                                     std::uint32_t cell_sum, const Draw& draw) {
    const CellBox box = cell_box(grid, cell);
    const std::uint64_t share = ((static_cast<std::uint64_t>(draw.k) << 32) + draw.uniform) /
                                static_cast<std::uint64_t>(draw.n);  // of the distribution, in 2^-32
    const std::uint32_t value = static_cast<std::uint32_t>(share * cell_sum >> 32);
    const std::uint32_t* const prefix = cumulative + box.offset;
    int lo = 0, hi = box.width * box.height - 1;  // first pixel whose prefix sum exceeds the value
    while (lo < hi) {
        const int mid = (lo + hi) / 2;
        if (prefix[mid] > value)
            hi = mid;
        else
            lo = mid + 1;
    }
    return {2 * (box.x0 + lo % box.width) + 1, 2 * (box.y0 + lo / box.width) + 1};
}

}  // namespace hexrelief::step
