// The launch configuration that all stages share, and launches of cooperative grids: kernels whose blocks all
// run at once and may wait for each other.
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <type_traits>

#include "cuda/common/check.h"

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

inline constexpr unsigned kGridWarps = 16;  // warps of a block; there is one block per multiprocessor
inline constexpr unsigned kGridThreads = 32 * kGridWarps;
inline constexpr unsigned kMostGridBlocks = 1024;

// Memory through which the blocks of a grid communicate; successive kernels of a stream share one.
struct GridBoard {
    unsigned long long sums[kMostGridBlocks];
    // The votes' members are 0 before the first launch.
    unsigned last_vote;  // number of the last vote
    unsigned votes[2];   // for odd and for even vote numbers: the last vote that a thread said yes to
};

// Launches one block of kGridThreads threads per multiprocessor. `what` says what is
// being done, for Error(device).
template <typename... Parameters>
void launch_cooperative(const Launch& launch, void (*kernel)(Parameters...), unsigned shared_bytes,
                        const char* what, const std::type_identity_t<Parameters>&... arguments) {
    void* pointers[] = {const_cast<void*>(static_cast<const void*>(&arguments))...};
    check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(kernel), dim3(launch.multiprocessors),
                                      dim3(kGridThreads), pointers, shared_bytes, launch.stream),
          what);
}

}  // namespace hexrelief::cuda
