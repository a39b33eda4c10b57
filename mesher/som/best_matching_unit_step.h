// Competition step: finds the best matching unit of a point by a spiral search over the cells (paper,
// section 4.2, Fig. 6).
#pragma once

#include <cstdint>

#include "mesher/som/cell_matrix_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// The neurons of each cell at the last refresh: ids[begin[cell] .. end[cell]), in any order.
struct CellLists {
    const std::uint32_t* begin;
    const std::uint32_t* end;
    const std::uint32_t* ids;
};

inline constexpr std::uint32_t kNoNeuron = 0xFFFFFFFFu;

struct Candidate {
    float squared_distance = 3.0e38f;
    std::uint32_t neuron = kNoNeuron;
};

// Returns the nearer of two candidates; ties go to the lower index, so that the order of
// comparison does not matter.
HEXRELIEF_HD Candidate nearer(const Candidate& a, const Candidate& b) {
    const bool b_wins = b.squared_distance < a.squared_distance ||
                        (b.squared_distance == a.squared_distance && b.neuron < a.neuron);
    return b_wins ? b : a;
}

// Returns the neuron with its squared distance to the point (px, py).
HEXRELIEF_HD Candidate measure(std::uint32_t neuron, const float* x, const float* y, float px, float py) {
    const float dx = x[neuron] - px, dy = y[neuron] - py;
    return {dx * dx + dy * dy, neuron};
}

// Squared distance from a point to a cell's square, px^2; 0 inside.
HEXRELIEF_HD float cell_distance(const CellGrid& grid, int cell_x, int cell_y, float px, float py) {
    const float left = static_cast<float>(cell_x * grid.co), up = static_cast<float>(cell_y * grid.co);
    const float dx = max_of(max_of(left - px, px - left - static_cast<float>(grid.co)), 0.0f);
    const float dy = max_of(max_of(up - py, py - up - static_cast<float>(grid.co)), 0.0f);
    return dx * dx + dy * dy;
}

// Squared distance from a point in cell (cell_x, cell_y) to the nearest cell of ring `ring` >=
// 1 around it, px^2.
HEXRELIEF_HD float ring_distance(const CellGrid& grid, int cell_x, int cell_y, int ring, float px, float py) {
    const float left = px - static_cast<float>((cell_x - ring + 1) * grid.co);
    const float right = static_cast<float>((cell_x + ring) * grid.co) - px;
    const float up = py - static_cast<float>((cell_y - ring + 1) * grid.co);
    const float down = static_cast<float>((cell_y + ring) * grid.co) - py;
    const float nearest = min_of(min_of(left, right), min_of(up, down));
    return nearest * nearest;
}

// Gives cell k of ring `ring` >= 1 around (0, 0) as (u, v), 0 <= k < 8 ring: first the top and bottom rows,
// then the sides between them.
HEXRELIEF_HD void ring_cell(int ring, int k, int& u, int& v) {
    const int side = 2 * ring + 1;
    if (k < 2 * side) {
        u = k % side - ring;
        v = k < side ? -ring : ring;
    } else {
        u = k % 2 ? ring : -ring;
        v = (k - 2 * side) / 2 - ring + 1;
    }
}

// Number of rings that a search may visit: ssr, or all rings if ssr is 0 (unlimited).
HEXRELIEF_HD int ring_limit(const CellGrid& grid, int ssr) {
    return ssr > 0 ? ssr : max_of(grid.columns, grid.rows);
}

// Searches the point's own cell first, then the cells around it ring by ring, skipping the cells of a ring
// that lie beyond the nearest neuron found so far. Returns the nearest of all neurons if ssr is 0 and the
// lists are fresh, and kNoNeuron if the rings within ssr are empty.
HEXRELIEF_HD Candidate spiral_search(const CellGrid& grid, const CellLists& lists, const float* x,
                                     const float* y, HalfPoint point, int ssr) {
    const float px = static_cast<float>(point.x) * 0.5f, py = static_cast<float>(point.y) * 0.5f;
    const int cx = point.x / (2 * grid.co), cy = point.y / (2 * grid.co), limit = ring_limit(grid, ssr);
    Candidate best;
    for (int ring = 0; ring <= limit; ++ring) {
        const float reach = best.squared_distance;  // distance to the nearest neuron of the preceding rings
        if (ring > 0 && ring_distance(grid, cx, cy, ring, px, py) > reach) break;
        for (int v = max_of(0, cy - ring); v <= min_of(grid.rows - 1, cy + ring); ++v) {
            const int stride = v == cy - ring || v == cy + ring || ring == 0 ? 1 : 2 * ring;
            for (int u = cx - ring; u <= cx + ring; u += stride) {
                if (u < 0 || u >= grid.columns || cell_distance(grid, u, v, px, py) > reach) continue;
                const int cell = v * grid.columns + u;
                for (std::uint32_t i = lists.begin[cell]; i < lists.end[cell]; ++i)
                    best = nearer(best, measure(lists.ids[i], x, y, px, py));
            }
        }
    }
    return best;
}

}  // namespace hexrelief::step
