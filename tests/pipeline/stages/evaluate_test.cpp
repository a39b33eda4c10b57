#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/stages/disparity.h"
#include "tests/pipeline/stages/expect_error.h"

namespace hexrelief {
namespace {

constexpr float kNo = kUnknownDisparity;

TEST(Evaluation, CountsBadPixelsAndCoverage) {
    const DisparityMap truth{3, 2, {10, 10, 10, 10, 10, kNo}};
    const DisparityMap map{3, 2, {10.5f, 9, 13, kNo, 15, 99}};
    const DisparityEvaluation e = evaluate_disparity(map, truth);
    EXPECT_EQ(e.truth_pixels, 5);
    EXPECT_DOUBLE_EQ(e.bad_percent[0], 80);  // exactly 0.5 px off is not above 0.5 px; unknown is bad
    EXPECT_DOUBLE_EQ(e.bad_percent[1], 60);
    EXPECT_DOUBLE_EQ(e.bad_percent[2], 60);
    EXPECT_DOUBLE_EQ(e.bad_percent[3], 40);
    EXPECT_DOUBLE_EQ(e.coverage_percent, 80);
    EXPECT_DOUBLE_EQ(e.average_error_px, 9.5 / 4);
    EXPECT_DOUBLE_EQ(e.rms_error_px, std::sqrt((0.25 + 1 + 9 + 25) / 4));
}

TEST(Evaluation, OfTheTruthItselfIsPerfect) {
    const DisparityMap truth{2, 1, {3, kNo}};
    const DisparityEvaluation e = evaluate_disparity(truth, truth);
    EXPECT_EQ(e.bad_percent[0], 0);
    EXPECT_EQ(e.coverage_percent, 100);
    EXPECT_EQ(e.average_error_px, 0);
}

TEST(Evaluation, RefusesOtherSizesAndEmptyTruth) {
    expect_error(ErrorKind::input, "2x1", [] { evaluate_disparity({2, 1, {1, 2}}, {1, 1, {1}}); });
    expect_error(ErrorKind::input, "no known pixel", [] { evaluate_disparity({1, 1, {1}}, {1, 1, {kNo}}); });
}

}  // namespace
}  // namespace hexrelief
