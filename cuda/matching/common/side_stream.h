// A second stream, for work that the device does beside what it does in the call's own stream.
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

// A place in a stream's work, for which another stream waits. To be set anew as often as one likes: who
// waits, waits for the place that was set last.
class StreamMark {
  public:
    StreamMark() { check(cudaEventCreateWithFlags(&event_, cudaEventDisableTiming), "creating an event"); }
    StreamMark(const StreamMark&) = delete;
    StreamMark& operator=(const StreamMark&) = delete;
    ~StreamMark() { cudaEventDestroy(event_); }

    // After all that was launched in the stream.
    void set(cudaStream_t stream) { check(cudaEventRecord(event_, stream), "marking a stream"); }
    // What is launched in the stream from now on comes after the mark.
    void let_wait(cudaStream_t stream) const {
        check(cudaStreamWaitEvent(stream, event_, 0), "waiting for a stream");
    }

  private:
    cudaEvent_t event_ = nullptr;
};

class SideStream {
  public:
    SideStream() { check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "creating a stream"); }
    SideStream(const SideStream&) = delete;
    SideStream& operator=(const SideStream&) = delete;
    ~SideStream() { cudaStreamDestroy(stream_); }

    cudaStream_t get() const { return stream_; }
    // What comes next here comes after all that was launched in `stream`.
    void begin_after(cudaStream_t stream) {
        begun_.set(stream);
        begun_.let_wait(stream_);
    }
    // Marks what was launched here, until the next mark.
    void mark() { done_.set(stream_); }
    // What comes next in `stream` comes after the mark.
    void let_wait_for_mark(cudaStream_t stream) const { done_.let_wait(stream); }

  private:
    cudaStream_t stream_ = nullptr;
    StreamMark begun_, done_;
};

}  // namespace hexrelief::cuda
