// OpenCV's number of threads. For rooms that link OpenCV.
#pragma once

#include <algorithm>
#include <opencv2/core/utility.hpp>

namespace hexrelief {

// Sets OpenCV's number of threads, which is global, and restores it afterwards. Results do not depend on it.
class OpenCvThreads {
  public:
    explicit OpenCvThreads(int threads) : before_(cv::getNumThreads()) {
        // OpenCV's thread library prints a warning if there are more threads than the machine has CPUs.
        cv::setNumThreads(std::clamp(threads, 1, cv::getNumberOfCPUs()));
    }
    ~OpenCvThreads() { cv::setNumThreads(before_); }
    OpenCvThreads(const OpenCvThreads&) = delete;
    OpenCvThreads& operator=(const OpenCvThreads&) = delete;

  private:
    const int before_;
};

}  // namespace hexrelief
