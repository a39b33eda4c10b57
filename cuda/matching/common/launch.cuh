// Launches kernels that follow each other closely.
#pragma once

#include <cuda_runtime.h>

#include <utility>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

// Waits for the results of the preceding kernels; the first statement of each kernel that launch() starts.
__device__ inline void begin_kernel() {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
    cudaGridDependencySynchronize();
#endif
}

// The size of a launch.
struct Blocks {
    dim3 grid, block;
    std::size_t shared_bytes = 0;  // dynamic shared memory of a block
};
// Starts a kernel, which must call begin_kernel() first. From compute capability 9.0 on it is set up while
// the preceding kernel of the stream ends (programmatic dependent launch).
template <typename... Parameters, typename... Arguments>
void launch(const char* what, cudaStream_t stream, const Blocks& blocks, void (*kernel)(Parameters...),
            Arguments&&... arguments) {
    cudaFuncAttributes code{};
    check(cudaFuncGetAttributes(&code, kernel), what);
    cudaLaunchAttribute early{};
    early.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    early.val.programmaticStreamSerializationAllowed = 1;
    cudaLaunchConfig_t config{};
    config.gridDim = blocks.grid;
    config.blockDim = blocks.block;
    config.dynamicSmemBytes = blocks.shared_bytes;
    config.stream = stream;
    config.attrs = &early;
    config.numAttrs = code.ptxVersion >= 90 ? 1 : 0;
    check(cudaLaunchKernelEx(&config, kernel, std::forward<Arguments>(arguments)...), what);
}

}  // namespace hexrelief::cuda
