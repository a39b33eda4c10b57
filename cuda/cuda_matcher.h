// The matcher on an NVIDIA GPU: match_pair() with the same parameters and, to the byte, the same results as
// pipeline/matching/matcher.h. cuda_mesher.h lists the devices.
//
// Needs what CudaMesher needs. All errors of the device are Error(device) with one line that says what failed
// and what to do; the object may be used again after an error.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "pipeline/matching/matcher.h"

namespace hexrelief {

// What the kernels of a stage took on the device; transfers are not in it.
struct CudaMatchingTime {
    const char* stage;
    double seconds;
};

// A context on the first device with a stream and memory that is kept from call to call, and the launches of
// the last one, which a pair of the same size and configuration has as well. Memory: some 250
// bytes a pixel (.63 GiB for 1800x1500x256), but some 90 where pictures are matched in bands of rows (5.8 GiB
// for 8192x8192x1024). Any thread may call, but only one at a time.
class CudaMatcher {
  public:
    // Throws as CudaMesher does.
    CudaMatcher();
    ~CudaMatcher();

    // hexrelief::match_pair on the device. Throws Error(device) also where memory is too small, for more than
    // 2048 disparities and for sides of more than 32,767 px. times: null, or what the stages took, in their
    // order; asking for it makes the call a little slower.
    MatchedMap match_pair(const StereoPair& pair, const MatchingConfig& config,
                          std::vector<CudaMatchingTime>* times = nullptr);

    // Device memory of the last call.
    std::size_t device_bytes() const;
    // On the device, from the last call's first kernel to its last: transfers of pictures and maps are not
    // in it.
    double kernel_seconds() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace hexrelief
