// The cellular matrix over one level's image: its layout, and how its cells extract
// points (paper, section 4).
#pragma once

#include <cstddef>
#include <cstdint>

#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// A grid of cells of co x co pixels, row-major; the cells of the last column and row may be smaller.
struct CellGrid {
    int width, height;  // px of the level's image
    int co;             // side of a cell, px
    int columns, rows;  // ceil(width / co) x ceil(height / co)
};

HEXRELIEF_HD CellGrid make_cell_grid(int width, int height, int co) {
    return {width, height, co, (width + co - 1) / co, (height + co - 1) / co};
}

// The pixels of one cell.
struct CellBox {
    int x0, y0, width, height;
    std::size_t offset;  // index of the cell's first pixel in an array that stores the pixels cell by cell
};

HEXRELIEF_HD CellBox cell_box(const CellGrid& grid, int cell) {
    const int x0 = cell % grid.columns * grid.co, y0 = cell / grid.columns * grid.co;
    const int w = min_of(grid.co, grid.width - x0), h = min_of(grid.co, grid.height - y0);
    return {x0, y0, w, h, static_cast<std::size_t>(y0) * grid.width + static_cast<std::size_t>(x0) * h};
}

// Returns the cell that contains a position; positions on or beyond the image's border belong
// to the nearest cell.
HEXRELIEF_HD int cell_of(const CellGrid& grid, float x, float y) {
    const int cx = clamp_to(static_cast<int>(x / static_cast<float>(grid.co)), 0, grid.columns - 1);
    const int cy = clamp_to(static_cast<int>(y / static_cast<float>(grid.co)), 0, grid.rows - 1);
    return cy * grid.columns + cx;
}

// Number of bits of a quantised pixel weight, chosen so that a cell's sum stays below 2^32.
HEXRELIEF_HD int weight_bits(int co) {
    int bits = 24;
    while (bits > 1 &&
           (static_cast<std::uint64_t>(co) * static_cast<std::uint64_t>(co) << bits) > 0xFFFFFFFFull)
        --bits;
    return bits;
}

// Returns a pixel's weight as an integer; `scale` maps the largest density to the largest integer.
HEXRELIEF_HD std::uint32_t quantise_weight(float density, float scale) {
    return static_cast<std::uint32_t>(density * scale + 0.5f);
}

// Writes the cell's cumulative distribution, its local roulette wheel (Eq. 7): the inclusive prefix sums of
// its quantised weights in raster order. Returns the cell's sum.
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

// Expected number of points that the cell extracts in an iteration (Eq. 6), in 32.32 fixed point. Up to 1 it
// is the activation probability; with delta above 1 dense cells extract several points.
HEXRELIEF_HD std::uint64_t cell_activity(std::uint32_t cell_sum, std::uint32_t largest_sum, double delta) {
    return static_cast<std::uint64_t>(static_cast<double>(cell_sum) / static_cast<double>(largest_sum) *
                                      delta * 4294967296.0);
}

// Number of points that the cell extracts in this iteration: floor(activity + uniform), which is 0 or 1
// if delta <= 1.
HEXRELIEF_HD int draw_count(std::uint64_t activity, std::uint32_t uniform) {
    return static_cast<int>((activity + uniform) >> 32);
}

// A point in half pixels, so that pixel centres are integers: x = 2 * column + 1.
struct HalfPoint {
    int x, y;
};

// Draw k of the n draws of a cell in an iteration, with 32 random bits.
struct Draw {
    int k, n;
    std::uint32_t uniform;
};

// Returns the point of a draw from the cell's cumulative distribution (Eq. 7), found by binary search. The
// draws are stratified: draw k falls into part k of n equal parts of the distribution.
HEXRELIEF_HD HalfPoint extract_point(const CellGrid& grid, int cell, const std::uint32_t* cumulative,
                                     std::uint32_t cell_sum, const Draw& draw) {
    const CellBox box = cell_box(grid, cell);
    const std::uint64_t share = ((static_cast<std::uint64_t>(draw.k) << 32) + draw.uniform) /
                                // position within the distribution, in 2^-32
                                static_cast<std::uint64_t>(draw.n);
    const std::uint32_t value = static_cast<std::uint32_t>(share * cell_sum >> 32);
    const std::uint32_t* const prefix = cumulative + box.offset;
    // search for the first pixel whose prefix sum exceeds the value
    int lo = 0, hi = box.width * box.height - 1;
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
