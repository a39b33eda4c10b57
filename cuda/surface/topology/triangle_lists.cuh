// Lists of triangles that warps fill together.
#pragma once

#include "cuda/common/triangle_groups.cuh"
#include "cuda/surface/topology/label_triangles.h"

namespace hexrelief::cuda {

// Puts those of the numbers of a warp's lanes that are wanted on a list.
__device__ inline void put_on_list(unsigned* list, unsigned& count, int step, unsigned number, bool wanted) {
    const unsigned all = __ballot_sync(kAllLanes, wanted);
    if (all == 0) return;
    unsigned at = threadIdx.x % 32 == 0 ? atomicAdd(&count, __popc(all)) : 0;
    at = __shfl_sync(kAllLanes, at, 0) + count_before_lane(all);
    if (wanted) list[static_cast<int>(at) * step] = number;
}

// One of LabelArrays' lists: triangles of few rows from its beginning on, those of many back from its end.
struct TriangleList {
    unsigned* triangles;
    unsigned capacity;

    // Those of the warp's lanes that are wanted; many: whether it is one of many rows.
    __device__ void put(LabelArrays::Listed& counts, unsigned t, bool wanted, bool many) const {
        put_on_list(triangles, counts.few, 1, t, wanted && !many);
        put_on_list(triangles + capacity - 1, counts.many, -1, t, wanted && many);
    }
    // The i-th, those of many rows first.
    __device__ unsigned at(const LabelArrays::Listed& counts, unsigned i) const {
        return triangles[i < counts.many ? capacity - 1 - i : i - counts.many];
    }
};

}  // namespace hexrelief::cuda
