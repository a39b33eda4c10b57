#include "cuda/common/check.h"
#include "cuda/som/untangle.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr int kSweepsAtOnce = 4;  // sweeps launched before the host checks whether a triangle is still folded

struct Vertex {
    int index, column, row;
    bool valid;
};

__device__ __forceinline__ Vertex this_vertex(const step::Lattice& lattice) {
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    return {i, i % lattice.columns, i / lattice.columns, i < lattice.columns * lattice.rows};
}

__global__ void regular_kernel(LevelView level) {
    const Vertex v = this_vertex(level.lattice);
    if (!v.valid) return;
    float x = step::regular_x(v.column, v.row, level.lattice.columns, level.extent_x);
    float y = step::regular_y(v.row, level.lattice.rows, level.extent_y);
    if (level.pinned) step::pin_to_border(border_of(level), v.column, v.row, x, y);
    level.x[v.index] = x;
    level.y[v.index] = y;
}

__global__ void prolongate_kernel(LevelView from, LevelView to) {
    const Vertex v = this_vertex(to.lattice);
    if (!v.valid) return;
    const step::Refinement refinement{from.lattice, to.lattice, to.pinned};
    float x = step::prolongate(from.x, refinement, v.column, v.row, to.extent_x);
    float y = step::prolongate(from.y, refinement, v.column, v.row, to.extent_y);
    if (to.pinned) step::pin_to_border(border_of(to), v.column, v.row, x, y);
    to.x[v.index] = x;
    to.y[v.index] = y;
}

__device__ __forceinline__ step::LatticeView view_of(const LevelView& level) {
    return {level.lattice.columns, level.lattice.rows, level.x, level.y};
}

// All kernels of a sweep do nothing once an earlier sweep has found no fold.
__global__ void mark_kernel(LevelView level, UntangleScratch scratch, int sweep) {
    if (sweep > 0 && !scratch.any[sweep - 1]) return;
    const Vertex v = this_vertex(level.lattice);
    if (!v.valid || !step::folded(view_of(level), v.column, v.row)) return;
    scratch.smoothed[v.index] = 1;
    scratch.any[sweep] = 1;
}

__global__ void copy_marks_kernel(LevelView level, UntangleScratch scratch, int sweep) {
    const Vertex v = this_vertex(level.lattice);
    if (v.valid && scratch.any[sweep]) scratch.before[v.index] = scratch.smoothed[v.index];
}

__global__ void grow_kernel(LevelView level, UntangleScratch scratch, int sweep) {
    const Vertex v = this_vertex(level.lattice);
    if (!v.valid || !scratch.any[sweep]) return;
    for (int k = 0; k < 6; ++k) {
        const int n = step::neighbour(view_of(level), v.column, v.row, k);
        if (n >= 0 && scratch.before[n]) scratch.smoothed[v.index] = 1;
    }
}

__global__ void smooth_kernel(LevelView level, UntangleScratch scratch, int sweep) {
    const Vertex v = this_vertex(level.lattice);
    if (!v.valid || !scratch.any[sweep]) return;
    step::Position p{level.x[v.index], level.y[v.index]};
    if (scratch.smoothed[v.index])
        p = step::smoothed_position(view_of(level), {level.pinned, level.outline}, sweep, v.column, v.row);
    scratch.x[v.index] = p.x;
    scratch.y[v.index] = p.y;
}

__global__ void accept_kernel(LevelView level, UntangleScratch scratch, int sweep, const std::uint8_t* held) {
    const Vertex v = this_vertex(level.lattice);
    if (!v.valid || !scratch.any[sweep] || !scratch.smoothed[v.index]) return;
    if (held && held[v.index]) return;
    level.x[v.index] = scratch.x[v.index];
    level.y[v.index] = scratch.y[v.index];
}

__global__ void shift_kernel(LevelView level, float x, float y) {
    const Vertex v = this_vertex(level.lattice);
    if (!v.valid) return;
    level.x[v.index] = x + level.x[v.index];
    level.y[v.index] = y + level.y[v.index];
}

int blocks_of(const LevelView& level) {
    return blocks_for(static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows, kBlock);
}

}  // namespace

void place_regular(const Launch& launch, const LevelView& level) {
    regular_kernel<<<blocks_of(level), kBlock, 0, launch.stream>>>(level);
    check_launch("placing the lattice");
}

void prolongate(const Launch& launch, const LevelView& from, const LevelView& to) {
    prolongate_kernel<<<blocks_of(to), kBlock, 0, launch.stream>>>(from, to);
    check_launch("refining the lattice");
}

void untangle(const Launch& launch, const LevelView& level, const UntangleScratch& scratch,
              const std::uint8_t* held) {
    const std::size_t neurons = static_cast<std::size_t>(level.lattice.columns) * level.lattice.rows;
    const int blocks = blocks_of(level);
    check(cudaMemsetAsync(scratch.smoothed, 0, neurons, launch.stream), "clearing marks");
    check(cudaMemsetAsync(scratch.any, 0, (step::kMostUntangleSweeps + 1) * sizeof(int), launch.stream),
          "clearing flags");
    for (int sweep = 0; sweep < step::kMostUntangleSweeps; ++sweep) {
        mark_kernel<<<blocks, kBlock, 0, launch.stream>>>(level, scratch, sweep);
        if (sweep % kSweepsAtOnce == 0) {
            int any = 0;
            check(
                cudaMemcpyAsync(&any, &scratch.any[sweep], sizeof any, cudaMemcpyDeviceToHost, launch.stream),
                "reading a flag");
            check(cudaStreamSynchronize(launch.stream), "repairing folds");
            if (!any) return;
        }
        if (sweep % step::kUntangleGrowth == step::kUntangleGrowth - 1) {
            copy_marks_kernel<<<blocks, kBlock, 0, launch.stream>>>(level, scratch, sweep);
            grow_kernel<<<blocks, kBlock, 0, launch.stream>>>(level, scratch, sweep);
        }
        smooth_kernel<<<blocks, kBlock, 0, launch.stream>>>(level, scratch, sweep);
        accept_kernel<<<blocks, kBlock, 0, launch.stream>>>(level, scratch, sweep, held);
        check_launch("repairing folds");
    }
}

void shift(const Launch& launch, const LevelView& level, float x, float y) {
    shift_kernel<<<blocks_of(level), kBlock, 0, launch.stream>>>(level, x, y);
    check_launch("moving the lattice");
}

}  // namespace hexrelief::cuda
