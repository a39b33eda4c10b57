// The resources that a matcher keeps from call to call: memory, streams and their marks, and recorded
// launches.
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/common/arena.h"
#include "cuda/common/check.h"
#include "cuda/common/staging.h"

namespace hexrelief::cuda {

// A point in a stream's work for which another stream waits. It may be set any number of times; a waiting
// stream waits for the point that was set last.
class StreamMark {
  public:
    StreamMark() { check(cudaEventCreateWithFlags(&event_, cudaEventDisableTiming), "creating an event"); }
    StreamMark(const StreamMark&) = delete;
    StreamMark& operator=(const StreamMark&) = delete;
    ~StreamMark() { cudaEventDestroy(event_); }

    // Marks the end of all work launched in the stream so far.
    void set(cudaStream_t stream) { check(cudaEventRecord(event_, stream), "marking a stream"); }
    // Lets all later work of the stream come after the mark.
    void let_wait(cudaStream_t stream) const {
        check(cudaStreamWaitEvent(stream, event_, 0), "waiting for a stream");
    }

  private:
    cudaEvent_t event_ = nullptr;
};

// The second stream, and its synchronisation with the call's stream.
class SideStream {
  public:
    SideStream() { check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "creating a stream"); }
    SideStream(const SideStream&) = delete;
    SideStream& operator=(const SideStream&) = delete;
    ~SideStream() { cudaStreamDestroy(stream_); }

    cudaStream_t get() const { return stream_; }
    // Lets all later work of this stream come after the work launched in `stream` so far.
    void begin_after(cudaStream_t stream) {
        begun_.set(stream);
        begun_.let_wait(stream_);
    }
    // Marks the end of the work launched in this stream so far, until the next mark.
    void mark() { done_.set(stream_); }
    // Lets all later work of `stream` come after the mark.
    void let_wait_for_mark(cudaStream_t stream) const { done_.let_wait(stream); }

  private:
    cudaStream_t stream_ = nullptr;
    StreamMark begun_, done_;
};

struct Workspace {
    cudaStream_t stream = nullptr;
    SideStream side;
    Arena arena;
    Staging staging;

    // Creates the streams on the current device.
    Workspace() { check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "creating a stream"); }
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;
    ~Workspace() { cudaStreamDestroy(stream); }
};

// Records launches that are repeated as a CUDA graph: one by one they take the host longer than small kernels
// run. Records at the second call, because making a graph takes about as long as a call, which would not pay
// for a single one.
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
