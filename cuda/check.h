// Turns CUDA's error codes into Error(device). Compiles with the host compiler.
#pragma once

#include <cuda_runtime_api.h>

#include <string>

#include "pipeline/data/error.h"

namespace hexrelief::cuda {

// Clears the sticky error and throws where a call failed; `what` says what was being done.
inline void check(cudaError_t status, const char* what) {
    if (status == cudaSuccess) return;
    cudaGetLastError();
    std::string message = std::string("cuda: ") + what + ": " + cudaGetErrorString(status);
    if (status == cudaErrorMemoryAllocation) message += "; use --backend cpu or a smaller map";
    throw Error(ErrorKind::device, message);
}

// After a kernel launch.
inline void check_launch(const char* what) {
    check(cudaGetLastError(), what);
}

}  // namespace hexrelief::cuda
