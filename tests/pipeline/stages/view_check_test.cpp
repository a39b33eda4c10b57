#include "pipeline/stages/sgbm.h"

#include <gtest/gtest.h>

namespace hexrelief::stages {
namespace {

constexpr std::int16_t kNo = kUnmatched;

TEST(LeftRightCheck, KeepsWhatTheRightViewConfirms) {
    RawDisparities left{6, 1, {kNo, 32, 32, 32, 24, 40}};
    const RawDisparities right{6, 1, {32, kNo, 24, 24, 0, 0}};
    check_left_right(left, right, 0.5);
    // The pixel x=1 leaves the image, x=2 agrees at 0, x=3 finds nothing at 1, x=4 (1.5 px) agrees at 2,
    // and x=5 (2.5 px) does not agree.
    EXPECT_EQ(left.values, (std::vector<std::int16_t>{kNo, kNo, 32, kNo, 24, kNo}));
}

TEST(LeftRightCheck, RoundsNegativeDisparitiesDown) {
    RawDisparities left{4, 1, {-8, -24, kNo, -16}};
    const RawDisparities right{4, 1, {0, -8, -24, 0}};
    check_left_right(left, right, 0);
    EXPECT_EQ(left.values, (std::vector<std::int16_t>{-8, -24, kNo, kNo}));
}

TEST(Speckles, AreSmallPatches) {
    RawDisparities map{6, 1, {160, 160, 160, 480, 480, 160}};
    remove_speckles(map, 2, 2);
    EXPECT_EQ(map.values, (std::vector<std::int16_t>{160, 160, 160, kNo, kNo, kNo}));
    remove_speckles(map, 0, 2);
    EXPECT_EQ(map.values[0], 160);
}

}  // namespace
}  // namespace hexrelief::stages
