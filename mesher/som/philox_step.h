// Counter-based random numbers: Philox4x32-10 (Salmon et al., SC 2011, "Parallel random numbers: as easy as
// 1, 2, 3"). Every draw is a function of (seed, level, iteration, cell, draw), so no state is stored and the
// order of draws does not matter.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"

namespace hexrelief::step {

struct Random4 {
    std::uint32_t word[4];
};

// Returns the four random words of a counter. For a cell c0 = cell, c1 = iteration, c2 = level and c3 = block
// of four words. Word 0 of block 0 decides how many points the cell extracts; draw k uses word k + 1 of the
// sequence, which is in block (k + 1) / 4.
HEXRELIEF_HD Random4 philox(std::uint64_t seed, std::uint32_t c0, std::uint32_t c1, std::uint32_t c2,
                            std::uint32_t c3) {
    std::uint32_t k0 = static_cast<std::uint32_t>(seed), k1 = static_cast<std::uint32_t>(seed >> 32);
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t a = std::uint64_t{0xD2511F53u} * c0, b = std::uint64_t{0xCD9E8D57u} * c2;
        const std::uint32_t n0 = static_cast<std::uint32_t>(b >> 32) ^ c1 ^ k0;
        const std::uint32_t n2 = static_cast<std::uint32_t>(a >> 32) ^ c3 ^ k1;
        c1 = static_cast<std::uint32_t>(b);
        c3 = static_cast<std::uint32_t>(a);
        c0 = n0;
        c2 = n2;
        k0 += 0x9E3779B9u;
        k1 += 0xBB67AE85u;
    }
    return {{c0, c1, c2, c3}};
}

}  // namespace hexrelief::step
