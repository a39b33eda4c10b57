// Records launches that are repeated: one by one they take the host longer than small kernels run.
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

// Records them as a CUDA graph at the second call, because making a graph takes about as long as a call,
// which would not pay for a single one.
class Recording {
  public:
    Recording() = default;
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;
    ~Recording() {
        if (graph_) cudaGraphExecDestroy(graph_);
    }

    // Runs launch(), which launches into the stream, and into others that begin after it and for which it
    // waits: each time the same kernels with the same arguments.
    template <typename Launch>
    void run(cudaStream_t stream, const Launch& launch) {
        if (++times_ == 1) return launch();
        if (!graph_) record(stream, launch);
        check(cudaGraphLaunch(graph_, stream), "launching a graph");
    }

  private:
    template <typename Launch>
    void record(cudaStream_t stream, const Launch& launch) {
        check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), "recording");
        cudaGraph_t recorded = nullptr;
        try {
            launch();
        } catch (...) {
            cudaStreamEndCapture(stream, &recorded);
            if (recorded) cudaGraphDestroy(recorded);
            throw;
        }
        check(cudaStreamEndCapture(stream, &recorded), "recording");
        const cudaError_t error = cudaGraphInstantiate(&graph_, recorded, 0);
        cudaGraphDestroy(recorded);
        check(error, "recording");
    }

    int times_ = 0;
    cudaGraphExec_t graph_ = nullptr;
};

}  // namespace hexrelief::cuda
