#include "pipeline/batch/memory.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace hexrelief::batch {
namespace {

std::uint64_t available_memory() {
    std::ifstream file("/proc/meminfo");
    for (std::string word; file >> word;)
        if (word == "MemAvailable:") {
            std::uint64_t kib = 0;
            file >> kib;
            return kib * 1024;
        }
    return std::numeric_limits<std::uint64_t>::max();
}

// Returns what the control group may still use; the largest number if it has no limit.
std::uint64_t group_memory() {
    std::uint64_t limit = 0, used = 0;
    std::ifstream("/sys/fs/cgroup/memory.max") >> limit;
    std::ifstream("/sys/fs/cgroup/memory.current") >> used;
    return limit == 0 ? std::numeric_limits<std::uint64_t>::max() : limit - std::min(limit, used);
}

}  // namespace

std::uint64_t memory_to_use() {
    return std::min(available_memory(), group_memory()) / 4 * 3;
}

std::uint64_t MemoryRule::expected(std::uint64_t estimate) const {
    return static_cast<std::uint64_t>(factor_ * static_cast<double>(estimate));
}

bool MemoryRule::fits(std::uint64_t expected, std::uint64_t in_use) const {
    return in_use == 0 || (in_use < limit_ && expected <= limit_ - in_use);
}

void MemoryRule::learn(std::uint64_t estimate, std::uint64_t taken) {
    factor_ = std::max(factor_, static_cast<double>(taken) / static_cast<double>(estimate));
}

}  // namespace hexrelief::batch
