// Measures time by the device's own clock.
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

// A pair of events around the launches between them.
class Stopwatch {
  public:
    explicit Stopwatch(cudaStream_t stream) : stream_(stream) {
        check(cudaEventCreate(&begin_), "creating an event");
        if (const cudaError_t status = cudaEventCreate(&end_); status != cudaSuccess) {
            cudaEventDestroy(begin_);
            check(status, "creating an event");
        }
    }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;
    ~Stopwatch() {
        cudaEventDestroy(begin_);
        cudaEventDestroy(end_);
    }
    void begin() { check(cudaEventRecord(begin_, stream_), "timing"); }
    void end() { check(cudaEventRecord(end_, stream_), "timing"); }
    // Returns the measured time; to be called once the stream has passed the end.
    double seconds() const {
        float milliseconds = 0;
        check(cudaEventElapsedTime(&milliseconds, begin_, end_), "timing");
        return milliseconds * 1e-3;
    }

  private:
    cudaStream_t stream_;
    cudaEvent_t begin_ = nullptr, end_ = nullptr;
};

}  // namespace hexrelief::cuda
