// Lists of triangles that warps fill together.
#pragma once

#include "cuda/common/triangle_groups.cuh"
#include "cuda/surface/topology/label_triangles.h"

namespace hexrelief::cuda {

// Appends the wanted ones of the numbers in a warp's lanes to a list.
__device__ inline void put_on_list(unsigned* list, unsigned& count, int step, unsigned number, bool wanted) {
    const unsigned all = __ballot_sync(kAllLanes, wanted);
    if (all == 0) return;
    unsigned at = threadIdx.x % 32 == 0 ? atomicAdd(&count, __popc(all)) : 0;
    at = __shfl_sync(kAllLanes, at, 0) + count_before_lane(all);
    if (wanted) list[static_cast<int>(at) * step] = number;
}

// One of LabelArrays' lists: triangles with few rows from its beginning on, those with many rows
// back from its end.
struct TriangleList {
    unsigned* triangles;
    unsigned capacity;

    // Appends the wanted ones of the triangles in a warp's lanes; many: true for a triangle with many rows.
    __device__ void put(LabelArrays::Listed& counts, unsigned t, bool wanted, bool many) const {
        put_on_list(triangles, counts.few, 1, t, wanted && !many);
        put_on_list(triangles + capacity - 1, counts.many, -1, t, wanted && many);
    }
    // Returns the i-th triangle; those with many rows come first.
    __device__ unsigned at(const LabelArrays::Listed& counts, unsigned i) const {
        return triangles[i < counts.many ? capacity - 1 - i : i - counts.many];
    }
};

}  // namespace hexrelief::cuda
