// Work that may run wild, in a process of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace hexrelief::inspect {

struct WorkLimits {
    unsigned seconds = 0;        // of processor time
    std::uint64_t memory = 0;    // bytes of addresses beyond what the process has; not under AddressSanitizer
    std::size_t most_bytes = 0;  // of a result
};

using WorkBytes = std::vector<std::uint8_t>;

// What `work` returns, which is computed in a forked process, so that a crash or a limit ends that one alone.
// Throws Error(input) with what `work` throws, or where the process ends otherwise; messages begin with
// `opening`. Where no process can be started `work` runs in this one.
WorkBytes run_limited(const WorkLimits& limits, const std::string& opening,
                      const std::function<WorkBytes()>& work);

}  // namespace hexrelief::inspect
