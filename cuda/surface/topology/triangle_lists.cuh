// Lists of triangles that warps fill together.
#pragma once

#include "cuda/common/triangle_groups.cuh"
#include "cuda/surface/topology/label_triangles.h"

namespace hexrelief::cuda {

// Puts those of the numbers of a warp's lanes that are wanted on a list.
__device__ inline void put_on_list(unsigned* list, unsigned& count, int step, unsigned number, bool wanted) {
    const unsigned lane = threadIdx.x % 32, all = __ballot_sync(kAllLanes, wanted);
    if (all == 0) return;
    unsigned at = lane == 0 ? atomicAdd(&count, __popc(all)) : 0;
    at = __shfl_sync(kAllLanes, at, 0) + __popc(all & ((1u << lane) - 1));
    if (wanted) list[static_cast<int>(at) * step] = number;
}

__device__ inline void put_on_list(const LabelArrays& a, unsigned which, unsigned capacity,
                                   LabelArrays::Listed& counts, unsigned t, bool wanted, bool is_large) {
    put_on_list(a.lists[which], counts.few, 1, t, wanted && !is_large);
    put_on_list(a.lists[which] + capacity - 1, counts.many, -1, t, wanted && is_large);
}
// The i-th of a list.
__device__ inline unsigned on_list(const LabelArrays& a, unsigned which, unsigned capacity,
                                   const LabelArrays::Listed& counts, unsigned i) {
    return a.lists[which][i < counts.many ? capacity - 1 - i : i - counts.many];
}

}  // namespace hexrelief::cuda
