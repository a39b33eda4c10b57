#include "pipeline/stages/sgbm.h"

#include <gtest/gtest.h>

namespace hexrelief::stages {
namespace {

constexpr std::int16_t kNo = kUnmatched;

TEST(Speckles, AreSmallPatches) {
    RawDisparities map{6, 1, {160, 160, 160, 480, 480, 160}};
    remove_speckles(map, 2, 2);
    EXPECT_EQ(map.values, (std::vector<std::int16_t>{160, 160, 160, kNo, kNo, kNo}));
    remove_speckles(map, 0, 2);
    EXPECT_EQ(map.values[0], 160);
}

}  // namespace
}  // namespace hexrelief::stages
