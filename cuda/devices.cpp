#include <cuda_runtime_api.h>

#include "cuda/common/check.h"
#include "cuda/cuda_mesher.h"

namespace hexrelief {

namespace {

struct Listing {
    std::vector<CudaDevice> devices;
    std::string why;
};

Listing ask_driver() {
    Listing listing;
    int count = 0, driver = 0;
    const cudaError_t status = cudaGetDeviceCount(&count);
    cudaGetLastError();
    if (status != cudaSuccess) count = 0;
    if (count == 0) {
        cudaDriverGetVersion(&driver);
        listing.why = cuda::why_no_device(status, driver);
    }
    for (int i = 0; i < count; ++i) {
        cudaDeviceProp properties;
        if (cudaGetDeviceProperties(&properties, i) != cudaSuccess) continue;
        listing.devices.push_back({i, properties.name,
                                   std::to_string(properties.major) + "." + std::to_string(properties.minor),
                                   properties.totalGlobalMem, properties.multiProcessorCount});
    }
    return listing;
}

}  // namespace

std::vector<CudaDevice> list_cuda_devices(std::string* why) {
    static const Listing listing = ask_driver();  // once: it takes milliseconds a device
    if (why) *why = listing.why;
    return listing.devices;
}

void copy_from_cuda_device(void* target, const void* source, std::size_t bytes) {
    cuda::check(cudaDeviceSynchronize(), "waiting for an array");
    cuda::check(cudaMemcpy(target, source, bytes, cudaMemcpyDefault), "copying an array");
}

void end_cuda() {
    cudaDeviceReset();
}

}  // namespace hexrelief
