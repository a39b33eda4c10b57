// From a pair on the host to its disparities on the host.
#pragma once

#include <memory>

#include "cuda/matching/common/workspace.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief::cuda {

class DeviceMatcher {
  public:
    DeviceMatcher();
    ~DeviceMatcher();

    // The same bytes as matching::match_pair(). The clock runs between the transfers.
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config);

    Workspace work;

  private:
    struct Plan;
    std::unique_ptr<Plan> plan_;  // of the last call
};

}  // namespace hexrelief::cuda
