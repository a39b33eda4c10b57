#include "mesher/som/philox_step.h"

#include <gtest/gtest.h>

#include <array>

namespace hexrelief::step {
namespace {

struct KnownAnswer {
    std::array<std::uint32_t, 4> counter;
    std::array<std::uint32_t, 2> key;
    std::array<std::uint32_t, 4> answer;
};

// The known-answer vectors that the generator's authors published for ten rounds.
TEST(Philox, PublishedKnownAnswers) {
    const KnownAnswer known[] = {
        {{0, 0, 0, 0}, {0, 0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
        {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
         {0xffffffff, 0xffffffff},
         {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
        {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
         {0xa4093822, 0x299f31d0},
         {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
    };
    for (const KnownAnswer& k : known) {
        const std::uint64_t seed = k.key[0] | static_cast<std::uint64_t>(k.key[1]) << 32;
        const Random4 random = philox(seed, k.counter[0], k.counter[1], k.counter[2], k.counter[3]);
        for (int i = 0; i < 4; ++i) EXPECT_EQ(random.word[i], k.answer[i]) << "word " << i;
    }
}

}  // namespace
}  // namespace hexrelief::step
