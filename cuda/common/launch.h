// The launch configuration that all stages share.
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>

namespace hexrelief::cuda {

struct Launch {
    cudaStream_t stream;
    int multiprocessors;
    int cluster_blocks;  // size of the largest thread-block cluster that can balance a level, 0 = no clusters
    int clusters;        // number of such clusters that run at once
};

// Returns the number of blocks of `block` threads that `items` items need.
inline int blocks_for(std::size_t items, int block) {
    return static_cast<int>((items + block - 1) / block);
}

}  // namespace hexrelief::cuda
