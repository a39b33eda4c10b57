// Runs work that may crash or run away in a process of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace hexrelief::inspect {

struct WorkLimits {
    unsigned seconds = 0;  // processor time
    // Bytes of address space beyond the process's own; not under AddressSanitizer.
    std::uint64_t memory = 0;
    std::size_t most_bytes = 0;  // largest size of a result
};

using WorkBytes = std::vector<std::uint8_t>;

// Returns what `work` returns, computed in a forked process, so that a crash or a limit ends only that
// process. Throws Error(input) with the message of
// `work`'s exception, or if the process ends abnormally or none can be started; the message then begins
// with `opening`.
WorkBytes run_limited(const WorkLimits& limits, const std::string& opening,
                      const std::function<WorkBytes()>& work);

}  // namespace hexrelief::inspect
