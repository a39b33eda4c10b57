// The kernels of the paper's Algorithm 1: its underlined lines, and line 12 as one kernel or as three.
#pragma once

#include <curand_kernel.h>

#include "tests/cuda/paper/steps.cuh"

namespace hexrelief::paper {
namespace {

__device__ __forceinline__ int this_thread() {
    return blockIdx.x * blockDim.x + threadIdx.x;
}

__global__ void regular_kernel(View view) {
    const int i = this_thread();
    if (i >= view.lattice.columns * view.lattice.rows) return;
    const int column = i % view.lattice.columns, row = i / view.lattice.columns;
    view.positions[i] = {(static_cast<float>(column) + 0.25f + 0.5f * static_cast<float>(row & 1)) *
                             static_cast<float>(view.grid.width) / static_cast<float>(view.lattice.columns),
                         (static_cast<float>(row) + 0.5f) * static_cast<float>(view.grid.height) /
                             static_cast<float>(view.lattice.rows)};
}

__global__ void cell_density_kernel(View view) {
    const int cell = this_thread();
    if (cell >= cells_of(view)) return;
    const step::CellBox box = step::cell_box(view.grid, cell);
    float sum = 0;
    for (int y = box.y0; y < box.y0 + box.height; ++y)
        for (int x = box.x0; x < box.x0 + box.width; ++x)
            sum += view.density[static_cast<std::size_t>(y) * view.grid.width + x];
    view.sums[cell] = sum;
}

__global__ void probability_kernel(View view, float largest, float delta) {
    const int cell = this_thread();
    if (cell < cells_of(view)) view.probability[cell] = largest > 0 ? view.sums[cell] / largest * delta : 0;
}

// Draws two random numbers for each cell and iteration; a cell's sequence continues after the last call's.
__global__ void random_kernel(View view, unsigned long long seed, unsigned long long drawn, int iterations) {
    const int cell = this_thread(), cells = cells_of(view);
    if (cell >= cells) return;
    curandStatePhilox4_32_10_t state;
    curand_init(seed, static_cast<unsigned long long>(cell), drawn, &state);
    for (int i = 0; i < 2 * iterations; ++i)
        view.random[static_cast<std::size_t>(i) * cells + cell] = curand_uniform(&state);
}

template <Memory kMemory>
__global__ void refresh_kernel(View view) {
    const int i = this_thread();
    if (i >= view.lattice.columns * view.lattice.rows) return;
    const int2 id{i % view.lattice.columns, i / view.lattice.columns};
    const float2 w = view.positions[i];
    const int cell = step::cell_of(view.grid, w.x, w.y);
    const int rank = atomicAdd(&view.count[cell], 1);
    if (rank >= view.neurons_per_cell) return;
    if (kMemory == Memory::version1) {
        const std::size_t at = static_cast<std::size_t>(rank) * cells_of(view) + cell;
        view.id_x[at] = id.x;
        view.id_y[at] = id.y;
    } else {
        view.id[static_cast<std::size_t>(cell) * view.neurons_per_cell + rank] = id;
    }
}

template <Memory kMemory>
__global__ void single_kernel(View view, const float* random, float alpha, float sigma) {
    const int cell = this_thread();
    if (cell >= cells_of(view) || !is_active(view, cell, random)) return;
    const float2 point = extract(view, cell, random);
    const int winner = search<kMemory>(view, point);
    if (winner >= 0) learn<kMemory == Memory::version2_texture>(view, winner, point, alpha, sigma);
}

__global__ void extraction_kernel(View view, const float* random) {
    const int cell = this_thread();
    if (cell >= cells_of(view)) return;
    view.points[cell] = is_active(view, cell, random) ? extract(view, cell, random) : float2{-1, -1};
}

template <Memory kMemory>
__global__ void search_kernel(View view) {
    const int cell = this_thread();
    if (cell >= cells_of(view)) return;
    const float2 point = view.points[cell];
    view.winners[cell] = point.x < 0 ? -1 : search<kMemory>(view, point);
}

template <Memory kMemory>
__global__ void learning_kernel(View view, float alpha, float sigma) {
    const int cell = this_thread();
    if (cell >= cells_of(view)) return;
    const int winner = view.winners[cell];
    if (winner >= 0)
        learn<kMemory == Memory::version2_texture>(view, winner, view.points[cell], alpha, sigma);
}

}  // namespace
}  // namespace hexrelief::paper
