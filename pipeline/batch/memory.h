// Estimates the memory that units take, so that only as many run as there is room for.
#pragma once

#include <cstdint>

namespace hexrelief::batch {

// Returns three quarters of the memory that is available now, within the process's control group.
std::uint64_t memory_to_use();

// Corrects estimates by the memory that units took: if one took more than its estimate, those of later units
// are increased by the same factor.
class MemoryRule {
  public:
    explicit MemoryRule(std::uint64_t limit) : limit_(limit) {}
    std::uint64_t expected(std::uint64_t estimate) const;
    // True if another unit may begin beside those whose expected bytes are in use; a single one always may.
    bool fits(std::uint64_t expected, std::uint64_t in_use) const;
    void learn(std::uint64_t estimate, std::uint64_t taken);

  private:
    std::uint64_t limit_;
    double factor_ = 1;
};

}  // namespace hexrelief::batch
