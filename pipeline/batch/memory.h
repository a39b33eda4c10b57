// How much memory units take, so that only as many are under way as there is room for.
#pragma once

#include <cstdint>

namespace hexrelief::batch {

// Three quarters of what the system has to give now, within its control group.
std::uint64_t memory_to_use();

// Learns from what units took: where one took more than its estimate, those to come are taken for as much
// larger.
class MemoryRule {
  public:
    explicit MemoryRule(std::uint64_t limit) : limit_(limit) {}
    std::uint64_t expected(std::uint64_t estimate) const;
    // Another unit may begin beside those whose expected bytes are in use; one alone always may.
    bool fits(std::uint64_t expected, std::uint64_t in_use) const;
    void learn(std::uint64_t estimate, std::uint64_t taken);

  private:
    std::uint64_t limit_;
    double factor_ = 1;
};

}  // namespace hexrelief::batch
