// Tests the learning rule and its tables (Eq. 3 and 4), and the lattice distance that they use.
#include "mesher/som/learning_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "mesher/common/lattice_step.h"
#include "mesher/som/level_plan.h"

namespace hexrelief::som {
namespace {

void add(step::LearningSums& sums, const LearningTables& tables, int d, int half_x, int half_y) {
    sums.gain += tables.gain[d];
    sums.x += tables.gain[d] * static_cast<std::uint32_t>(half_x);
    sums.y += tables.gain[d] * static_cast<std::uint32_t>(half_y);
    sums.decay += tables.decay[d];
}

TEST(Learning, OneWinnerGivesEquation3) {
    std::mt19937 random(3);
    for (const double sigma : {1.0, 2.5, 6.0, 12.0, 24.0})
        for (const double alpha : {1.0, 0.9, 0.5, 0.1, 0.01}) {
            const LearningTables tables = learning_tables(alpha, sigma);
            ASSERT_EQ(tables.radius, static_cast<int>(sigma));
            for (int d = 0; d <= tables.radius; ++d) {
                const int half_x = static_cast<int>(random() % 1800) * 2 + 1,
                          half_y = static_cast<int>(random() % 1500) * 2 + 1;
                float x = static_cast<float>(random() % 100000) * 0.018f,
                      y = static_cast<float>(random() % 100000) * 0.015f;
                const double a = alpha * std::exp(-d * d / (sigma * sigma));
                const double expected_x = x + a * (half_x * 0.5 - x), expected_y = y + a * (half_y * 0.5 - y);
                step::LearningSums sums;
                add(sums, tables, d, half_x, half_y);
                step::learn(step::target_of(sums, x, y), 1800, 1500, x, y);
                // rounding in float at 1,800 px is 1e-4; the share's tables are accurate to 2e-5 of the way
                EXPECT_NEAR(x, expected_x, 3e-4 + 2e-5 * std::abs(half_x * 0.5 - x))
                    << "alpha " << alpha << " sigma " << sigma << " d " << d;
                EXPECT_NEAR(y, expected_y, 3e-4 + 2e-5 * std::abs(half_y * 0.5 - y));
            }
        }
}

TEST(Learning, SeveralWinnersGiveTheProductRule) {
    std::mt19937 random(8);
    for (int round = 0; round < 200; ++round) {
        const double sigma = 1 + random() % 12, alpha = 0.02 + 0.9 * (random() % 1000) / 1000;
        const LearningTables tables = learning_tables(alpha, sigma);
        const double x0 = 500 + random() % 100, y0 = 400 + random() % 100;
        double product = 1, sum = 0, sum_x = 0, sum_y = 0;
        step::LearningSums sums;
        for (unsigned k = 0; k < 1 + random() % 60; ++k) {
            const int d = static_cast<int>(random() % (tables.radius + 1));
            const int half_x = 901 + 2 * static_cast<int>(random() % 200),
                      half_y = 701 + 2 * static_cast<int>(random() % 200);
            const double h = std::exp(-d * d / (sigma * sigma));
            product *= 1 - alpha * h;
            sum += h;
            sum_x += h * half_x * 0.5;
            sum_y += h * half_y * 0.5;
            add(sums, tables, d, half_x, half_y);
        }
        auto x = static_cast<float>(x0), y = static_cast<float>(y0);
        step::learn(step::target_of(sums, x, y), 1800, 1500, x, y);
        EXPECT_NEAR(x, x0 + (1 - product) * (sum_x / sum - x0), 0.1)
            << "round " << round;  // h is a multiple of 1/1024
        EXPECT_NEAR(y, y0 + (1 - product) * (sum_y / sum - y0), 0.1) << "round " << round;
    }
}

TEST(Learning, ShareIsAPowerOfTwoSeries) {
    for (std::uint32_t decay = 0; decay < step::kFullDecay; decay += 97)
        ASSERT_NEAR(step::learning_share(decay), 1 - std::exp2(-static_cast<double>(decay) / 65536), 3e-6)
            << decay;
    EXPECT_EQ(step::learning_share(0), 0);
    EXPECT_EQ(step::learning_share(step::kFullDecay), 1);
    EXPECT_EQ(step::learning_share(0xFFFFFFFFu), 1);
}

TEST(Learning, PositionsStayInTheImage) {
    const LearningTables tables = learning_tables(1, 1);
    step::LearningSums sums;
    add(sums, tables, 0, 2 * 99 + 1, 1);
    float x = 3, y = 70;
    step::learn(step::target_of(sums, x, y), 99.25f, 80, x,
                y);  // a coarse level's last pixel may extend beyond the image
    EXPECT_EQ(x, 99.25f);
    EXPECT_EQ(y, 0.5f);
}

TEST(Plan, RatesFallGeometrically) {
    MeshConfig config{.levels = 1, .t_max = 100, .sigma_init = 12};
    const std::vector<LevelPlan> plans = plan_levels(450, 375, config, {0, 0, 450, 375});
    ASSERT_EQ(plans.size(), 1u);
    ASSERT_EQ(plans[0].iterations.size(), 100u);
    EXPECT_EQ(plans[0].iterations[0].radius, 12);
    EXPECT_EQ(plans[0].iterations[50].radius, 3);  // sqrt(12)
    EXPECT_EQ(plans[0].iterations[99].radius, 1);
    // at distance 0 the share is alpha itself: 1, then 0.1 half way down to 0.01
    EXPECT_EQ(step::learning_share(plans[0].iterations[0].decay[0]), 1);
    EXPECT_NEAR(step::learning_share(plans[0].iterations[50].decay[0]), 0.1, 1e-4);
}

TEST(Plan, CoarseLatticesKeepTwelveVerticesASide) {
    for (const int levels : {0, 1, 2, 3, 6, 12})
        for (const int width : {18, 40, 75, 150, 450, 1800}) {
            MeshConfig config{.levels = levels};
            const int height = width * 5 / 6 + 3;
            const std::vector<LevelPlan> plans = plan_levels(width, height, config, {0, 0, width, height});
            ASSERT_FALSE(plans.empty());
            if (levels > 0) {
                EXPECT_LE(plans.size(), static_cast<std::size_t>(levels));
            }
            for (const LevelPlan& plan : plans) {
                if (plan.level == 0) continue;
                EXPECT_GE(std::min(plan.lattice.columns, plan.lattice.rows), 12)
                    << width << " px, level " << plan.level;
            }
            EXPECT_EQ(plans.back().level, 0);
        }
}

// Returns the steps between two vertices by walking: diagonal steps first, then along the row.
int walked_distance(int column_a, int row_a, int column_b, int row_b) {
    const int rows = std::abs(row_b - row_a);
    const int half_steps = std::abs((2 * column_b + row_b % 2) - (2 * column_a + row_a % 2));
    return rows + std::max(0, (half_steps - rows) / 2);
}

TEST(Lattice, RowSpansAgreeWithWalking) {
    const int columns = 13, rows = 11;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            for (int r = 0; r < rows; ++r)
                for (int c = 0; c < columns; ++c) {
                    const int d = walked_distance(column, row, c, r);
                    for (const int radius : {1, 3, 6}) {
                        if (std::abs(r - row) > radius) continue;
                        const step::RowSpan span = step::row_span(column, row, radius, r);
                        const bool inside = c >= span.first && c < span.first + span.length;
                        ASSERT_EQ(inside, d <= radius)
                            << column << "," << row << " to " << c << "," << r << " radius " << radius;
                        if (inside) {
                            ASSERT_EQ(step::span_distance(span, radius, c - span.first), d);
                        }
                    }
                }
}

TEST(Lattice, NeighboursAreTheSixAtDistanceOneInTurn) {
    for (const int row : {4, 5})
        for (int k = 0; k < 6; ++k) {
            const step::Offset o = step::neighbour_offset(row, k),
                               next = step::neighbour_offset(row, (k + 1) % 6);
            EXPECT_EQ(walked_distance(7, row, 7 + o.column, row + o.row), 1);
            EXPECT_EQ(walked_distance(7 + o.column, row + o.row, 7 + next.column, row + next.row), 1);
        }
}

}  // namespace
}  // namespace hexrelief::som
