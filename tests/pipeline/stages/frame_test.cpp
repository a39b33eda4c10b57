// The frame in which the parts of photographs' meshes that the left camera does not see end.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 100, kHeight = 40;
constexpr double kBox = 20, kWall = 4;
constexpr ViewPlace kLeft{0, 0, 0, 1, kWidth, kHeight};

TEST(Frame, BetweenFartherRowsWhatLiesBehindGoesOnBehindNearOnesNotAtTheLastRows) {
    for (const int first : {0, 18, 36}) {  // of four near rows
        SeenSurface seen{kLeft, Disparities(kWidth * kHeight, kWall)};
        std::fill_n(seen.disparities.begin() + first * kWidth, 4 * kWidth, kBox);
        const std::vector<Frame::Line> rows = frame_of(seen, 2).rows;
        EXPECT_EQ(rows[10].first_seen, 2 * kWall);
        EXPECT_EQ(rows[first + 1].first_seen, 2 * (first == 18 ? kWall : kBox)) << first;
        EXPECT_EQ(rows[first + 1].end_seen, kWidth - 2 * (first == 18 ? kWall : kBox)) << first;
    }
    // Rows that show nothing do not count as the first and the last.
    SeenSurface seen{kLeft, Disparities(kWidth * kHeight, kWall)};
    std::fill_n(seen.disparities.begin() + 30 * kWidth, 4 * kWidth, kBox);
    std::fill_n(seen.disparities.begin() + 34 * kWidth, 6 * kWidth, kNotCovered);
    EXPECT_EQ(frame_of(seen, 2).rows[32].first_seen, 2 * kBox);
    seen.disparities.assign(seen.disparities.size(), kNotCovered);
    EXPECT_TRUE(frame_of(seen, 2).rows[5].is_empty());
}

}  // namespace
}  // namespace hexrelief::stages
