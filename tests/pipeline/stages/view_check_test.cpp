#include "pipeline/stages/view_check.h"

#include <gtest/gtest.h>

namespace hexrelief {
namespace {

constexpr std::int16_t kNo = kUnmatched;

TEST(LeftRightCheck, KeepsWhatTheRightViewConfirms) {
    RawDisparities left{6, 1, {kNo, 32, 32, 32, 24, 40}};
    const RawDisparities right{6, 1, {32, kNo, 24, 24, 0, 0}};
    check_left_right(left, right, 0.5);
    // x=1 leaves the image, x=2 agrees at 0, x=3 finds nothing at 1, x=4 (1.5 px) agrees at 2, x=5 (2.5 px)
    // does not.
    EXPECT_EQ(left.values, (std::vector<std::int16_t>{kNo, kNo, 32, kNo, 24, kNo}));
}

TEST(LeftRightCheck, RoundsNegativeDisparitiesDown) {
    RawDisparities left{4, 1, {-8, -24, kNo, -16}};
    const RawDisparities right{4, 1, {0, -8, -24, 0}};
    check_left_right(left, right, 0);
    EXPECT_EQ(left.values, (std::vector<std::int16_t>{-8, -24, kNo, kNo}));
}

TEST(Fill, TakesTheFartherNeighbour) {
    const float no = kUnknownDisparity;
    DisparityMap map{5, 4, {no, no, no, no, no,  //
                            no, 9,  no, 4,  no,  //
                            7,  no, no, no, 8,   //
                            no, no, no, no, no}};
    fill_unknown(map);
    EXPECT_EQ(map.values, (std::vector<float>{9, 9, 4, 4, 4,  //
                                              9, 9, 4, 4, 4,  //
                                              7, 7, 7, 7, 8,  //
                                              7, 7, 7, 7, 8}));
}

TEST(Fill, LeavesAnEmptyMapEmpty) {
    DisparityMap map{2, 1, {kUnknownDisparity, kUnknownDisparity}};
    fill_unknown(map);
    EXPECT_EQ(map.values, (std::vector<float>{kUnknownDisparity, kUnknownDisparity}));
}

}  // namespace
}  // namespace hexrelief
