// Measures each stage by the device's own clock, for benchmarks.
#pragma once

#include <cuda_runtime_api.h>

#include <vector>

#include "cuda/common/check.h"

namespace hexrelief::cuda {

// Measures the total time and, if enabled, the time of each stage by an event after it. These events keep
// kernels from following each other closely.
class StageClock {
  public:
    struct Stage {
        const char* name;
        double seconds;
    };

    StageClock() = default;
    StageClock(const StageClock&) = delete;
    StageClock& operator=(const StageClock&) = delete;
    ~StageClock() {
        for (cudaEvent_t event : events_) cudaEventDestroy(event);
        if (end_) cudaEventDestroy(end_);
    }
    void enable(bool enabled) { enabled_ = enabled; }
    bool enabled() const { return enabled_; }
    void begin(cudaStream_t stream) {
        stream_ = stream;
        names_.clear();
        record(0);
    }
    // Assigns the work launched since the last call, or since begin(), to this stage.
    void ended(const char* name) {
        if (!enabled_) return;
        names_.push_back(name);
        record(names_.size());
    }
    // Ends the measured work.
    void end() {
        if (!end_) check(cudaEventCreate(&end_), "creating an event");
        check(cudaEventRecord(end_, stream_), "timing");
    }
    // Returns the total time, once the stream has passed the end; 0 before the first measurement.
    double seconds() const {
        if (!end_) return 0;
        float milliseconds = 0;
        check(cudaEventElapsedTime(&milliseconds, events_[0], end_), "timing");
        return milliseconds * 1e-3;
    }
    std::vector<Stage> stages() const {
        std::vector<Stage> result;
        for (std::size_t i = 0; i < names_.size(); ++i) {
            float milliseconds = 0;
            check(cudaEventElapsedTime(&milliseconds, events_[i], events_[i + 1]), "timing");
            result.push_back({names_[i], milliseconds * 1e-3});
        }
        return result;
    }

  private:
    void record(std::size_t i) {
        if (i == events_.size()) {
            events_.push_back(nullptr);
            check(cudaEventCreate(&events_.back()), "creating an event");
        }
        check(cudaEventRecord(events_[i], stream_), "timing");
    }

    cudaStream_t stream_ = nullptr;
    bool enabled_ = false;
    std::vector<cudaEvent_t> events_;
    cudaEvent_t end_ = nullptr;
    std::vector<const char*> names_;
};

}  // namespace hexrelief::cuda
