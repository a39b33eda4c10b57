// Turns CUDA's error codes into Error(device) with a one-line message. Compiles with the host compiler.
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <string>

#include "pipeline/data/error.h"

namespace hexrelief::cuda {

// Returns "13.0" for 13000.
inline std::string version_text(int version) {
    return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

// Explains why there is no device, by the status that counting them returned. driver_version: 0 if
// no driver is loaded.
inline std::string why_no_device(cudaError_t status, int driver_version) {
    if (driver_version == 0) return "no NVIDIA driver is loaded";
    if (status == cudaErrorInsufficientDriver)
        return "the driver is too old: it serves CUDA " + version_text(driver_version) +
               ", this program needs " + version_text(CUDART_VERSION) + "; update the driver";
    if (status == cudaSuccess || status == cudaErrorNoDevice) return "the driver sees no device";
    return std::string("no usable device: ") + cudaGetErrorString(status);
}

// Returns the error for a failed call. `what` says what was being done.
inline Error device_error(cudaError_t status, const std::string& what) {
    std::string message = "backend cuda: ";
    switch (status) {
        case cudaErrorMemoryAllocation:
            message += "too little device memory (" + what + "); use --backend cpu or a smaller map";
            break;
        case cudaErrorInsufficientDriver:
        case cudaErrorUnsupportedPtxVersion:
            message += "the driver is too old for CUDA " + version_text(CUDART_VERSION) + " (" + what +
                       "); update the driver, or use --backend cpu";
            break;
        case cudaErrorNoKernelImageForDevice:
        case cudaErrorInvalidDeviceFunction:
            message += "this program holds no code for the device's architecture (" + what +
                       "); build it with -DCMAKE_CUDA_ARCHITECTURES=native, or use --backend cpu";
            break;
        default:
            message += what + ": " + cudaGetErrorString(status);
    }
    return Error(ErrorKind::device, message);
}

inline Error memory_error(std::size_t needed, std::size_t free, std::size_t total) {
    const auto mib = [](std::size_t bytes) { return std::to_string(bytes >> 20); };
    return Error(ErrorKind::device, "backend cuda: too little device memory: " + mib(needed) +
                                        " MiB more are needed, " + mib(free) + " of " + mib(total) +
                                        " MiB are free; use --backend cpu or a smaller map");
}

// Throws and clears CUDA's error if a call failed.
inline void check(cudaError_t status, const char* what) {
    if (status == cudaSuccess) return;
    cudaGetLastError();
    throw device_error(status, what);
}

// Throws if the kernel launch before it failed.
inline void check_launch(const char* what) {
    check(cudaGetLastError(), what);
}

// Calls cudaMalloc; if memory is too small, the error says how much there is.
inline void* allocate(std::size_t bytes) {
    void* data = nullptr;
    const cudaError_t status = cudaMalloc(&data, bytes);
    if (status == cudaErrorMemoryAllocation) {
        cudaGetLastError();
        std::size_t free = 0, total = 0;
        check(cudaMemGetInfo(&free, &total), "asking for the free memory");
        throw memory_error(bytes, free, total);
    }
    check(status, "allocating device memory");
    return data;
}

}  // namespace hexrelief::cuda
