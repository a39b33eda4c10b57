// The matcher on an NVIDIA GPU: match_pair() with the same parameters and, to the byte, the same results
// as pipeline/matching/matcher.h. cuda_mesher.h lists the devices.
//
// It has the same requirements as CudaMesher. All errors of the device are Error(device) with one line that
// says what failed and what to do; the object may be used again after an error.
#pragma once

#include <cstddef>
#include <memory>

#include "pipeline/matching/matcher.h"

namespace hexrelief::cuda {

// A context on the first device: a stream, memory that is kept from call to call, and the recorded launches
// of the last call, which are reused for a pair of the same size and configuration. Needs some 250 bytes of
// device memory a pixel (.63 GiB for 1800x1500x256), or some 90 if pictures are matched in bands of rows (5.8
// GiB for 8192x8192x1024). Any thread may call it, but only one at a time.
class CudaMatcher {
  public:
    // Throws what CudaMesher's constructor throws.
    CudaMatcher();
    ~CudaMatcher();

    // Runs matching::match_pair on the device. Also throws Error(device) if memory is too small, for more
    // than 2048 disparities, and for images of more than 32,767 px a side.
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config);

    // Returns the peak device memory of the last call.
    std::size_t device_bytes() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace hexrelief::cuda
