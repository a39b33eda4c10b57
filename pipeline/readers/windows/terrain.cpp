// Uses only + - * / and integers, so that every machine computes the same.
#include "pipeline/readers/windows/terrain.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::readers {
namespace {

constexpr float kBase_px = 20, kHills_px = 80, kCliff_px = 25;
constexpr int kCoarsest_px = 2048, kFinest_px = 8;  // cells of the noise, which halve from octave to octave
constexpr int kCliffCell_px = 640, kLakeCell_px = 1024;
constexpr float kCliffFrom = 0.55f, kLakeFrom = 0.85f;
constexpr int kPlot_px = 96;                         // a plot has one building or none
constexpr std::uint32_t kSinglesOf2To32 = 1u << 20;  // pixels without a disparity: one in 4096
enum Use : std::uint32_t { kHillUse = 1, kCliffUse = 100, kLakeUse, kPlotUse, kSingleUse };

// Mixes its arguments like the end of MurmurHash3.
std::uint32_t hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t h = a * 0x9e3779b1u ^ (b + 0x7f4a7c15u) * 0x85ebca6bu ^ (c + 0x165667b1u) * 0xc2b2ae35u;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

// Converts a hash to a number from 0 to 1.
float share(std::uint32_t h) {
    return static_cast<float>(h >> 8) / 16777216.0f;
}

float smooth(float t) {
    return t * t * (3 - 2 * t);
}

// Adds value noise of 0 to 1: out[i] += factor * noise(x + i, y).
void add_noise(int x, int y, int count, int cell, std::uint32_t seed, float factor, float* out) {
    const auto corner = [&](int column, int row) {
        return share(hash(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row), seed));
    };
    const int row = y / cell;
    const float down = smooth(static_cast<float>(y % cell) / static_cast<float>(cell));
    const auto edge = [&](int column) {
        const float top = corner(column, row);
        return top + (corner(column, row + 1) - top) * down;
    };
    for (int at = x; at < x + count;) {
        const int column = at / cell, end = std::min(x + count, (column + 1) * cell);
        const float left = edge(column), step = edge(column + 1) - left;
        for (; at < end; ++at) {
            const float t = smooth(static_cast<float>(at - column * cell) / static_cast<float>(cell));
            out[at - x] += factor * (left + step * t);
        }
    }
}

// Computes the ground, without buildings and holes.
void ground_row(int x, int y, int count, std::uint32_t seed, float* out) {
    std::fill_n(out, count, kBase_px);
    float factor = kHills_px;
    std::uint32_t use = kHillUse;
    for (int cell = kCoarsest_px; cell >= kFinest_px; cell /= 2) {
        add_noise(x, y, count, cell, hash(seed, use++, 0), factor, out);
        factor /= 2;
    }
    std::vector<float> cliffs(static_cast<std::size_t>(count));
    add_noise(x, y, count, kCliffCell_px, hash(seed, kCliffUse, 0), 1, cliffs.data());
    for (int i = 0; i < count; ++i)
        if (cliffs[static_cast<std::size_t>(i)] > kCliffFrom) out[i] += kCliff_px;
}

// Adds the building of one plot: a rectangle, rotated by an angle of a right triangle with integer sides.
void add_building(int column, int x, int y, int count, std::uint32_t seed, float* out) {
    constexpr int kTurns[][3] = {{1, 0, 1}, {4, 3, 5}, {3, 4, 5}, {12, 5, 13}};
    const int row = y / kPlot_px;
    const std::uint32_t plot =
        hash(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row), hash(seed, kPlotUse, 0));
    if (plot % 3 != 0) return;
    const auto draw = [&](std::uint32_t which, std::uint32_t below) {
        return static_cast<int>(hash(plot, which, 1) % below);
    };
    const auto [along, across, length] = kTurns[draw(0, 4)];
    const int half_width = 10 + draw(1, 24), half_height = 10 + draw(2, 18);
    const int centre_x = column * kPlot_px + kPlot_px / 2, centre_y = row * kPlot_px + kPlot_px / 2;
    float roof = 0;
    ground_row(centre_x, centre_y, 1, seed, &roof);
    roof += static_cast<float>(12 + draw(3, 40));
    const int first = std::max(x, column * kPlot_px), last = std::min(x + count, (column + 1) * kPlot_px);
    for (int at = first; at < last; ++at) {
        const int u = along * (at - centre_x) + across * (y - centre_y);
        const int v = along * (y - centre_y) - across * (at - centre_x);
        if (std::abs(u) <= half_width * length && std::abs(v) <= half_height * length) out[at - x] = roof;
    }
}

}  // namespace

void terrain_row(int x, int y, int count, std::uint32_t seed, float* out) {
    ground_row(x, y, count, seed, out);
    for (int column = x / kPlot_px; column * kPlot_px < x + count; ++column)
        add_building(column, x, y, count, seed, out);
    std::vector<float> lakes(static_cast<std::size_t>(count));
    add_noise(x, y, count, kLakeCell_px, hash(seed, kLakeUse, 0), 1, lakes.data());
    for (int i = 0; i < count; ++i) {
        const std::uint32_t single =
            hash(static_cast<std::uint32_t>(x + i), static_cast<std::uint32_t>(y), hash(seed, kSingleUse, 0));
        if (lakes[static_cast<std::size_t>(i)] > kLakeFrom || single < kSinglesOf2To32)
            out[i] = kUnknownDisparity;
    }
}

void write_terrain(MapWriter& writer, int width, int height, std::uint32_t seed, int threads) {
    constexpr int kBandRows = 64;
    ThreadPool pool(threads);
    std::vector<float> band(static_cast<std::size_t>(std::min(kBandRows, height)) * width);
    for (int top = 0; top < height; top += kBandRows) {
        const int rows = std::min(kBandRows, height - top);
        pool.parallel_for(static_cast<std::size_t>(rows), [&](std::size_t first, std::size_t last) {
            for (std::size_t row = first; row < last; ++row)
                terrain_row(0, top + static_cast<int>(row), width, seed, band.data() + row * width);
        });
        writer.write(band.data(), rows);
    }
}

}  // namespace hexrelief::readers
