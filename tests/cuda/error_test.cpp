// Tests the error message for each failure of the device; needs no device except in tests that say so.
#include <cuda_runtime_api.h>

#include "cuda/common/arena.h"
#include "cuda/common/check.h"
#include "tests/cuda/cuda_case.h"
#include "tests/expect_error.h"

namespace hexrelief::testing_cuda {
namespace {

bool holds(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(CudaErrors, NoDriver) {
    EXPECT_EQ(cuda::why_no_device(cudaErrorInsufficientDriver, 0), "no NVIDIA driver is loaded");
}

TEST(CudaErrors, TooOldDriverSaysBothVersions) {
    const std::string why = cuda::why_no_device(cudaErrorInsufficientDriver, 11080);
    for (const std::string& part : {std::string("too old"), std::string("11.8"),
                                    cuda::version_text(CUDART_VERSION), std::string("update the driver")})
        EXPECT_TRUE(holds(why, part)) << part << " in: " << why;
}

TEST(CudaErrors, DriverWithoutDevice) {
    EXPECT_EQ(cuda::why_no_device(cudaErrorNoDevice, 13000), "the driver sees no device");
    EXPECT_TRUE(holds(cuda::why_no_device(cudaErrorSystemNotReady, 13000), "no usable device: "));
}

TEST(CudaErrors, EachKindSaysWhichInOneLineAndExitsWith5) {
    const std::pair<cudaError_t, const char*> cases[] = {
        {cudaErrorMemoryAllocation, "too little device memory"},
        {cudaErrorInsufficientDriver, "driver is too old"},
        {cudaErrorUnsupportedPtxVersion, "driver is too old"},
        {cudaErrorNoKernelImageForDevice, "no code for the device's architecture"},
        {cudaErrorLaunchFailure, "training: "}};
    for (const auto& [status, part] : cases) {
        const std::string line = test::error_of([&] { cuda::check(status, "training"); }, ErrorKind{5});
        EXPECT_TRUE(line.starts_with("backend cuda: ") && holds(line, part)) << line;
        EXPECT_TRUE(holds(line, "training")) << line;
    }
    EXPECT_NO_THROW(cuda::check(cudaSuccess, "training"));
}

TEST(CudaErrors, TooLittleMemorySaysHowMuch) {
    const Error error = cuda::memory_error(std::size_t{3} << 30, std::size_t{1} << 30, std::size_t{8} << 30);
    EXPECT_EQ(static_cast<int>(error.kind()), 5);
    for (const char* part :
         {"too little device memory", "3072 MiB more", "1024 of 8192 MiB are free", "--backend cpu"})
        EXPECT_TRUE(holds(error.what(), part)) << error.what();
}

// If another program has taken the device's memory, the error is one line, and everything works once
// it is free again.
TEST(CudaErrors, FullDeviceIsSaidAndSurvived) {
    HEXRELIEF_NEEDS_DEVICE();
    cuda::CudaMesher mesher;
    const DensityMap large = testing_mesher::flat_density(4000, 3000);
    {
        std::vector<void*> taken;
        for (std::size_t chunk = std::size_t{1} << 34; chunk >= std::size_t{1} << 25; chunk /= 2) {
            void* data = nullptr;
            while (cudaMalloc(&data, chunk) == cudaSuccess) taken.push_back(data);
            cudaGetLastError();
        }
        EXPECT_CONTAINS(test::error_of([&] { mesher.solve(large, quick_config(3), {}); }, ErrorKind::device),
                        "too little device memory");
        for (void* const data : taken) cudaFree(data);
    }
    EXPECT_NO_THROW(mesher.solve(large, quick_config(3), {}));
}

TEST(CudaErrors, ArenaCountsWhatOneRunTakes) {
    HEXRELIEF_NEEDS_DEVICE();
    cuda::Arena arena;
    arena.take<char>(100000);
    EXPECT_GE(arena.peak_bytes(), 100000u);
    arena.reset();
    arena.take<char>(10);
    EXPECT_EQ(arena.peak_bytes(), 256u);
}

}  // namespace
}  // namespace hexrelief::testing_cuda
