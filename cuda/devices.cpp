#include <cuda_runtime_api.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "cuda/common/check.h"
#include "cuda/cuda_mesher.h"

namespace hexrelief::cuda {

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

// Returns the file descriptors through which this process reaches the driver; none if there is no /proc.
std::vector<int> driver_files() {
    namespace fs = std::filesystem;
    std::vector<int> files;
    std::error_code error;
    for (fs::directory_iterator entry("/proc/self/fd", error), end; !error && entry != end;
         entry.increment(error)) {
        std::error_code unreadable;
        if (fs::read_symlink(entry->path(), unreadable).native().starts_with("/dev/nvidia"))
            files.push_back(std::stoi(entry->path().filename()));
    }
    return files;
}

}  // namespace

std::vector<CudaDevice> list_cuda_devices(std::string* why) {
    static const Listing listing = ask_driver();  // only once, as it takes milliseconds per device
    if (why) *why = listing.why;
    return listing.devices;
}

void copy_from_cuda_device(void* target, const void* source, std::size_t bytes) {
    cuda::check(cudaDeviceSynchronize(), "waiting for an array");
    cuda::check(cudaMemcpy(target, source, bytes, cudaMemcpyDefault), "copying an array");
}

void end_cuda() {
    cudaDeviceReset();
    // The driver keeps more than a device's memory, which it gives back when its files are closed.
    for (const int file : driver_files()) close(file);
}

}  // namespace hexrelief::cuda
