// Launches of kernels whose blocks all run at once and may wait for each other.
#pragma once

#include <cuda_runtime_api.h>

#include <type_traits>

#include "cuda/common/check.h"
#include "cuda/common/launch.h"

namespace hexrelief::cuda {

inline constexpr unsigned kGridWarps = 16;  // of a block; one block a multiprocessor
inline constexpr unsigned kGridThreads = 32 * kGridWarps;
inline constexpr unsigned kMostGridBlocks = 1024;

// What the blocks of a grid tell each other; kernels that follow each other in a stream share one.
struct GridBoard {
    unsigned long long sums[kMostGridBlocks];
    // All 0 before the first launch.
    unsigned last_vote;  // number of the last one
    unsigned votes[2];   // odd and even numbers: the last that somebody said yes to
};

// One block of kGridThreads on each multiprocessor. Throws Error(device), which says `what` was being done.
template <typename... Parameters>
void launch_cooperative(const Launch& launch, void (*kernel)(Parameters...), unsigned shared_bytes,
                        const char* what, const std::type_identity_t<Parameters>&... arguments) {
    void* pointers[] = {const_cast<void*>(static_cast<const void*>(&arguments))...};
    check(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(kernel), dim3(launch.multiprocessors),
                                      dim3(kGridThreads), pointers, shared_bytes, launch.stream),
          what);
}

}  // namespace hexrelief::cuda
