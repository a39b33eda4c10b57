// The steps of the paper's Algorithm 2, with one thread per cell and with its races.
#pragma once

#include <cuda_runtime.h>

#include "mesher/common/lattice_step.h"
#include "mesher/som/best_matching_unit_step.h"
#include "mesher/som/cell_matrix_step.h"
#include "tests/cuda/paper/som.h"

namespace hexrelief::paper {

// The arrays and parameters of a run, without ownership.
struct View {
    step::CellGrid grid;
    step::Lattice lattice;
    int ssr, neurons_per_cell;
    const float* density;
    float* sums;         // density of each cell
    float* probability;  // probability of each cell's activation (Eq. 6)
    int* count;          // number of neurons in each cell
    int *id_x, *id_y;    // version 1: neuron k of cell c at k * cells + c
    int2* id;            // version 2: at c * neurons_per_cell + k
    float2* positions;
    cudaTextureObject_t texture;  // texture of that memory
    float* random;                // two per cell and iteration: activation, extraction; cells side by side
    float2* points;               // passed between the multiple kernels; x < 0 = the cell is not active
    int* winners;                 // -1 = none
};

__device__ __forceinline__ int cells_of(const View& view) {
    return view.grid.columns * view.grid.rows;
}

__device__ __forceinline__ bool is_active(const View& view, int cell, const float* random) {
    return random[cell] <= view.probability[cell] && view.sums[cell] > 0;
}

// Draws a pixel by the local roulette wheel (Eq. 7): goes along the cell's pixels until their sum
// reaches the drawn share.
__device__ inline float2 extract(const View& view, int cell, const float* random) {
    const step::CellBox box = step::cell_box(view.grid, cell);
    const float target = random[cells_of(view) + cell] * view.sums[cell];
    float sum = 0;
    float2 last{-1, -1};  // rounding may leave the sum of all pixels below the target
    for (int y = box.y0; y < box.y0 + box.height; ++y)
        for (int x = box.x0; x < box.x0 + box.width; ++x) {
            const float weight = view.density[static_cast<std::size_t>(y) * view.grid.width + x];
            if (weight <= 0) continue;
            sum += weight;
            last = {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
            if (sum >= target) return last;
        }
    return last;
}

template <Memory kMemory>
__device__ __forceinline__ int2 neuron_id(const View& view, int cell, int k) {
    if (kMemory == Memory::version1) {
        const std::size_t at = static_cast<std::size_t>(k) * cells_of(view) + cell;
        return {view.id_x[at], view.id_y[at]};
    }
    return view.id[static_cast<std::size_t>(cell) * view.neurons_per_cell + k];
}

// Searches a spiral: ring by ring until a cell holds a neuron, then only cells within the circle around the
// point through the nearest neuron of that cell; at most ssr rings.
template <Memory kMemory>
__device__ inline int search(const View& view, float2 point) {
    const int own = step::cell_of(view.grid, point.x, point.y);
    const int cx = own % view.grid.columns, cy = own / view.grid.columns;
    const int limit = step::ring_limit(view.grid, view.ssr);
    float nearest = 3.0e38f, reach = 3.0e38f;
    int winner = -1;
    for (int ring = 0; ring <= limit; ++ring) {
        if (ring > 0 && step::ring_distance(view.grid, cx, cy, ring, point.x, point.y) > reach) break;
        for (int k = 0; k < max(1, 8 * ring); ++k) {
            int u = 0, v = 0;
            if (ring > 0) step::ring_cell(ring, k, u, v);
            u += cx;
            v += cy;
            if (u < 0 || v < 0 || u >= view.grid.columns || v >= view.grid.rows) continue;
            if (step::cell_distance(view.grid, u, v, point.x, point.y) > reach) continue;
            const int cell = v * view.grid.columns + u;
            const int count = min(view.count[cell], view.neurons_per_cell);
            const bool first = winner < 0;
            for (int i = 0; i < count; ++i) {
                const int2 id = neuron_id<kMemory>(view, cell, i);
                const int neuron = id.y * view.lattice.columns + id.x;
                const float2 w = view.positions[neuron];
                const float dx = w.x - point.x, dy = w.y - point.y, distance = dx * dx + dy * dy;
                if (distance < nearest) {
                    nearest = distance;
                    winner = neuron;
                }
            }
            if (first && winner >= 0) reach = nearest;
        }
    }
    return winner;
}

template <bool kTexture>
__device__ __forceinline__ float2 position(const View& view, int neuron) {
    if (kTexture) return tex1Dfetch<float2>(view.texture, neuron);
    return view.positions[neuron];
}

// Applies Eq. 3 and 4 to all neurons around the winner, in place. Only the addition is atomic: its summand
// was computed from a position that other threads may have changed in the meantime.
template <bool kTexture>
__device__ inline void learn(const View& view, int winner, float2 point, float alpha, float sigma) {
    const int column = winner % view.lattice.columns, row = winner / view.lattice.columns;
    const int radius = static_cast<int>(sigma);
    for (int r = max(0, row - radius); r <= min(view.lattice.rows - 1, row + radius); ++r) {
        const step::RowSpan span = step::row_span(column, row, radius, r);
        for (int i = 0; i < span.length; ++i) {
            const int c = span.first + i;
            if (c < 0 || c >= view.lattice.columns) continue;
            const float d = static_cast<float>(step::span_distance(span, radius, i));
            const float gain = alpha * expf(-d * d / (sigma * sigma));
            const int neuron = r * view.lattice.columns + c;
            const float2 w = position<kTexture>(view, neuron);
            atomicAdd(&view.positions[neuron].x, gain * (point.x - w.x));
            atomicAdd(&view.positions[neuron].y, gain * (point.y - w.y));
        }
    }
}

}  // namespace hexrelief::paper
