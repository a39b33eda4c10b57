#include <cuda_runtime_api.h>

#include "cuda/cuda_mesher.h"

namespace hexrelief {

std::vector<CudaDevice> list_cuda_devices(std::string* why) {
    std::vector<CudaDevice> devices;
    int count = 0, driver = 0;
    const cudaError_t status = cudaGetDeviceCount(&count);
    cudaGetLastError();
    if (status != cudaSuccess) count = 0;
    if (count == 0 && why) {
        cudaDriverGetVersion(&driver);
        const auto version = [](int v) {
            return std::to_string(v / 1000) + "." + std::to_string(v % 1000 / 10);
        };
        if (driver == 0)
            *why = "no NVIDIA driver is loaded";
        else if (status == cudaErrorInsufficientDriver)
            *why = "the driver serves CUDA " + version(driver) + ", this program needs " +
                   version(CUDART_VERSION) + "; update the driver";
        else
            *why = std::string("no usable device: ") + cudaGetErrorString(status);
    }
    for (int i = 0; i < count; ++i) {
        cudaDeviceProp properties;
        if (cudaGetDeviceProperties(&properties, i) != cudaSuccess) continue;
        devices.push_back({i, properties.name,
                           std::to_string(properties.major) + "." + std::to_string(properties.minor),
                           properties.totalGlobalMem, properties.multiProcessorCount});
    }
    return devices;
}

}  // namespace hexrelief
