// Matches a pair on the device: from pictures on the host to disparities on the host.
#pragma once

#include <memory>

#include "cuda/matching/common/workspace.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief::cuda {

// A matcher with its stream, memory and recorded launches, kept from call to call.
class DeviceMatcher {
  public:
    DeviceMatcher();
    ~DeviceMatcher();

    // Returns the same bytes as matching::match_pair().
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config);

    Workspace work;

  private:
    struct Plan;
    std::unique_ptr<Plan> plan_;  // the last call's
};

}  // namespace hexrelief::cuda
