// How kernels are launched: what all stages share.
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>

namespace hexrelief::cuda {

// Launch configuration shared by the stages.
struct Launch {
    cudaStream_t stream;
    int multiprocessors;
    int cluster_blocks;  // of the largest thread-block cluster that balances, 0 = no clusters
    int clusters;        // of these at once
};

inline int blocks_for(std::size_t items, int block) {
    return static_cast<int>((items + block - 1) / block);
}

}  // namespace hexrelief::cuda
