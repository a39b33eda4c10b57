// A second stream, for work that the device does beside the call's own stream.
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/common/check.h"

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

}  // namespace hexrelief::cuda
