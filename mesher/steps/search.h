// Competition step: the best matching unit of a point, by spiral search over the cells (paper, section 4.2,
// Fig. 6).
#pragma once

#include <cstdint>

#include "mesher/steps/cells.h"
#include "mesher/steps/host_device.h"

namespace hexrelief::step {

// The neurons of each cell at the last refresh: ids[start[cell] .. start[cell + 1]), any order.
struct CellLists {
    const std::uint32_t* start;  // cells + 1
    const std::uint32_t* ids;
};

struct Candidate {
    float squared_distance = 3.0e38f;
    std::uint32_t neuron = 0xFFFFFFFFu;
};

// The nearer of two; ties go to the lowest index, so that the order of comparison does not matter.
HEXRELIEF_HD Candidate nearer(const Candidate& a, const Candidate& b) {
    const bool b_wins = b.squared_distance < a.squared_distance ||
                        (b.squared_distance == a.squared_distance && b.neuron < a.neuron);
    return b_wins ? b : a;
}

HEXRELIEF_HD Candidate measure(std::uint32_t neuron, const float* x, const float* y, float px, float py) {
    const float dx = x[neuron] - px, dy = y[neuron] - py;
    return {dx * dx + dy * dy, neuron};
}

// Squared distance from the point to the outside of the square of cells within `ring - 1` of its own cell:
// nothing in ring `ring` (as listed) is nearer. 0 where the square does not hold the point.
HEXRELIEF_HD float ring_bound(const CellGrid& grid, int cell_x, int cell_y, int ring, float px, float py) {
    const float left = px - static_cast<float>((cell_x - ring + 1) * grid.co);
    const float right = static_cast<float>((cell_x + ring) * grid.co) - px;
    const float up = py - static_cast<float>((cell_y - ring + 1) * grid.co);
    const float down = static_cast<float>((cell_y + ring) * grid.co) - py;
    const float bound = min_of(min_of(left, right), min_of(up, down));
    return bound > 0 ? bound * bound : 0.0f;
}

// Number of rings that a search may visit: ssr, or all where ssr is 0 (unlimited).
HEXRELIEF_HD int ring_limit(const CellGrid& grid, int ssr) {
    return ssr > 0 ? ssr : max_of(grid.columns, grid.rows);
}

// Rings are visited outward until a neuron is found and no listed cell of the next ring can hold a nearer
// one. Exact among all neurons where ssr is 0 and the lists are fresh. Returns no neuron (0xFFFFFFFF) where
// the rings within ssr are empty.
HEXRELIEF_HD Candidate spiral_search(const CellGrid& grid, const CellLists& lists, const float* x,
                                     const float* y, HalfPoint point, int ssr) {
    const float px = static_cast<float>(point.x) * 0.5f, py = static_cast<float>(point.y) * 0.5f;
    const int cx = point.x / (2 * grid.co), cy = point.y / (2 * grid.co), limit = ring_limit(grid, ssr);
    Candidate best;
    for (int ring = 0; ring <= limit; ++ring) {
        if (best.neuron != 0xFFFFFFFFu && ring_bound(grid, cx, cy, ring, px, py) > best.squared_distance)
            break;
        for (int v = max_of(0, cy - ring); v <= min_of(grid.rows - 1, cy + ring); ++v) {
            const bool edge = v == cy - ring || v == cy + ring;
            const int step = edge || ring == 0 ? 1 : 2 * ring;
            for (int u = cx - ring; u <= cx + ring; u += step) {
                if (u < 0 || u >= grid.columns) continue;
                const int cell = v * grid.columns + u;
                for (std::uint32_t i = lists.start[cell]; i < lists.start[cell + 1]; ++i)
                    best = nearer(best, measure(lists.ids[i], x, y, px, py));
            }
        }
    }
    return best;
}

}  // namespace hexrelief::step
