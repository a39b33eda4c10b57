// Integrals along the edges of a lattice's honeycomb cells, and the helper blocks that measure them while the
// communicator's own blocks do other work. Included only by balance.cu.
#pragma once

#include <cstdint>

#include "cuda/balance/balance.h"
#include "cuda/balance/work_items.cuh"
#include "mesher/balance/cell_equations_step.h"

namespace hexrelief::cuda {

// All boundary edges, the edges of the right border and those of bent first and last rows, in batches for a
// warp: kEdgeParts lanes measure a short edge, the whole warp a long one. The edges of a batch are far apart
// from each other, because long ones lie close together.
template <bool kSmall>
class EdgeBatches {
  public:
    const int count;

    __device__ explicit EdgeBatches(const step::BalanceView& v) : EdgeBatches(v, kEdges) {}

    // Measures a batch by a whole warp; v must be in global memory.
    __device__ __forceinline__ void measure(const step::BalanceView& v, int batch, int lane) const {
        constexpr unsigned kAll = 0xFFFFFFFFu;
        const int item = batch + lane / step::kEdgeParts * count;
        const Ends ends = ends_of(v, item);
        step::Edge edge{};
        int pixels = 0;
        if (ends.to >= 0) {
            edge = step::edge_between(v.x[ends.from], v.y[ends.from], v.x[ends.to], v.y[ends.to]);
            pixels = step::edge_pixels(edge);
        }
        int part = lane % step::kEdgeParts, parts = step::kEdgeParts, owner = -1;
        const bool is_long = pixels > step::kLongEdge_px, tells = part == 0;
        unsigned left = __ballot_sync(kAll, is_long && tells);
        bool active = pixels > 0 && !is_long;
        step::EdgeSums sums{};
        step::Edge its = edge;
#pragma unroll 1
        // all short edges, then one long edge after the other: this keeps a single copy of the code
        while (true) {
            step::EdgeSums s{};
            if (active) s = step::edge_part(v, its, part, parts);
#pragma unroll 1
            for (int other = 1; other < parts; other *= 2)
                s = s + step::EdgeSums{
                            __shfl_xor_sync(kAll, s.columns, other), __shfl_xor_sync(kAll, s.within, other),
                            __shfl_xor_sync(kAll, s.mass, other), __shfl_xor_sync(kAll, s.moment, other)};
            if (owner < 0 || lane == owner) sums = s;
            if (!left) break;
            owner = __ffs(left) - 1;
            left &= left - 1;
            its = {__shfl_sync(kAll, edge.x, owner), __shfl_sync(kAll, edge.y, owner),
                   __shfl_sync(kAll, edge.dx, owner), __shfl_sync(kAll, edge.dy, owner), 0};
            part = lane;
            parts = step::kLongEdgeParts;
            active = true;
        }
        if (!tells || item >= items_) return;
        const step::EdgeMass mass = ends.to >= 0 ? step::mass_of(v, edge, sums) : step::EdgeMass{0, 0, 0};
        if (item < boundary_edges_.count)
            v.edges[item] = mass;
        else if (item < ends_)
            v.right_flux[item - boundary_edges_.count] = mass.flux;
        else
            v.end_flux[item - ends_] = mass.flux;
    }

  private:
    static constexpr int kEdges = 32 / step::kEdgeParts;  // edges of a batch
    // The vertices of an edge; to < 0: there is no such edge.
    struct Ends {
        int from, to;
    };

    __device__ EdgeBatches(const step::BalanceView& v, int edges)
        : count((items_of(v) + edges - 1) / edges),
          boundary_edges_(0, v.lattice.rows, 3 * v.slots),
          ends_(3 * v.slots * v.lattice.rows + (v.pinned ? v.lattice.rows - 1 : 0)),
          items_(items_of(v)) {}
    __device__ static int items_of(const step::BalanceView& v) {
        return 3 * v.slots * v.lattice.rows + (v.pinned ? v.lattice.rows - 1 : 0) +
               (step::is_bent(v.outline) ? 2 * (v.lattice.columns - 1) : 0);
    }
    // Returns the vertices of an item's edge. Items are indices into v.edges, then rows of the right border,
    // then indices into v.end_flux.
    __device__ __forceinline__ Ends ends_of(const step::BalanceView& v, int item) const {
        const int columns = v.lattice.columns;
        if (item >= ends_) {
            if (item >= items_) return {-1, -1};
            const step::EdgeEnds ends = step::end_edge(v.lattice, item - ends_);
            return {ends.from, ends.to};
        }
        if (item >= boundary_edges_.count) {
            const int from = (item - boundary_edges_.count + 1) * columns - 1;
            return {from, from + columns};
        }
        const LatticeIndex p = boundary_edges_.at(item);
        const int slot = p.column / 3, j = p.column - 3 * slot;
        const int column = column_of_class(slot, p.row, 1);
        if (column >= columns) return {-1, -1};
        const step::Neighbour to = step::neighbour_of(v, column, p.row, 2 * j);
        return {p.row * columns + column, to.exists ? to.index : -1};
    }

    const RowItems<kSmall> boundary_edges_;
    const int ends_, items_;
};

// Signals between the communicator's blocks and the helpers: EdgeSignals count the blocks that have
// finished, over all iterations.
__device__ __forceinline__ void add_release(std::uint32_t* count, std::uint32_t value) {
    asm volatile("red.release.gpu.global.add.u32 [%0], %1;" ::"l"(count), "r"(value) : "memory");
}
__device__ __forceinline__ std::uint32_t wait_for_count(const std::uint32_t* count, std::uint32_t least) {
    std::uint32_t seen;
    do asm volatile("ld.acquire.gpu.global.u32 %0, [%1];" : "=r"(seen) : "l"(count) : "memory");
    while (seen < least);
    return seen;
}

// The helpers as the communicator's blocks see them. All threads of these blocks call its functions.
struct EdgeHelpers {
    static constexpr std::uint32_t kDismissed = 1u << 31;
    EdgeSignals* signals;
    std::uint32_t blocks, expected;

    // Requests a measurement; to be called once the block's vertices are in global memory.
    __device__ void request() {
        __syncthreads();
        if (threadIdx.x == 0) add_release(&signals->requested, 1);
    }
    // Waits until all edges are measured.
    __device__ void wait() {
        expected += blocks;
        if (threadIdx.x == 0) wait_for_count(&signals->measured, expected);
        __syncthreads();
    }
    // Ends all helpers; called by one block.
    __device__ void dismiss() const {
        if (threadIdx.x == 0) add_release(&signals->requested, kDismissed);
    }
};

// Measures edges as one of `helpers` blocks, for a communicator of `served_blocks` blocks,
// until it is dismissed.
__device__ void help(const BalanceJob& job, int served_blocks, int helper, int helpers) {
    __shared__ step::BalanceView v;
    if (threadIdx.x == 0) {
        v = job.view;
        step::set_units(v, job.masses[0], job.masses[1], job.floor);
    }
    __syncthreads();
    const EdgeBatches<true> edges(v);
    const int warp = threadIdx.x / 32, warps = blockDim.x / 32, lane = threadIdx.x % 32;
    for (std::uint32_t requested = served_blocks;; requested += served_blocks) {
        bool over = false;
        if (threadIdx.x == 0)
            over = wait_for_count(&job.signals->requested, requested) >= EdgeHelpers::kDismissed;
        if (__syncthreads_or(over)) return;
#pragma unroll 1
        for (int batch = helper + warp * helpers; batch < edges.count; batch += warps * helpers)
            edges.measure(v, batch, lane);
        __syncthreads();
        if (threadIdx.x == 0) add_release(&job.signals->measured, 1);
    }
}

}  // namespace hexrelief::cuda
