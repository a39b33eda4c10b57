// Launches kernels whose blocks all run at once and may wait for each other: cooperative grids.
#pragma once

#include <cuda_runtime_api.h>

#include <type_traits>

#include "cuda/common/check.h"
#include "cuda/common/launch.h"

namespace hexrelief::cuda {

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
