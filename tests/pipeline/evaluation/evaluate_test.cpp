#include "pipeline/evaluation/evaluate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/expect_error.h"

namespace hexrelief::evaluation {
namespace {

constexpr float kNo = kUnknownDisparity;

DisparityMap make_map(int width, int height, auto value) {
    DisparityMap map{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) map.values.push_back(static_cast<float>(value(x, y)));
    return map;
}

TEST(Evaluation, CountsBadPixelsAndCoverage) {
    const DisparityMap truth{3, 2, {10, 10, 10, 10, 10, kNo}};
    const DisparityMap map{3, 2, {10.5f, 9, 13, kNo, 15, 99}};
    const DisparityEvaluation e = evaluate_disparity(map, truth);
    EXPECT_EQ(e.truth_pixels, 5);
    // An error of exactly 0.5 px is not above 0.5 px; unknown pixels are bad.
    EXPECT_DOUBLE_EQ(e.bad_percent[0], 80);
    EXPECT_DOUBLE_EQ(e.bad_percent[1], 60);
    EXPECT_DOUBLE_EQ(e.bad_percent[2], 60);
    EXPECT_DOUBLE_EQ(e.bad_percent[3], 40);
    EXPECT_DOUBLE_EQ(e.bad_known_percent[0], 75);
    EXPECT_DOUBLE_EQ(e.bad_known_percent[2], 50);
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

TEST(Evaluation, NoughtIsUnknown) {
    const DisparityEvaluation e = evaluate_disparity({3, 1, {0, 1, 1}}, {3, 1, {1, 1, 0}});
    EXPECT_EQ(e.truth_pixels, 2);
    EXPECT_DOUBLE_EQ(e.bad_percent[3], 50);
    EXPECT_DOUBLE_EQ(e.coverage_percent, 50);
}

TEST(Evaluation, NonoccludedByWhatTheTruthHides) {
    // Columns 6 and 7, 3 px nearer, match the right view's columns 1 and 2, as do columns 3 and 4, which are
    // therefore hidden; columns 0 and 1 match outside the right view.
    const DisparityMap truth{9, 1, {2, 2, 2, 2, 2, 2, 5, 5, kNo}};
    const DisparityMap map{9, 1, {9, 9, 2, 9, kNo, 9, 5, 5, 5}};
    const DisparityEvaluation e = evaluate_disparity(map, truth);
    EXPECT_EQ(e.nonoccluded_pixels, 4);  // 2, 5, 6, 7
    EXPECT_DOUBLE_EQ(e.bad_nonoccluded_percent[2], 25);
    EXPECT_DOUBLE_EQ(e.bad_percent[2], 62.5);
}

TEST(Evaluation, NonoccludedByTheRightViewsTruth) {
    const DisparityMap truth{5, 1, {2, 2, 2.5f, 2, 2}};  // match columns -2, -1, 0, 1, 2: 2.5 rounds to 2
    const DisparityMap right{5, 1, {3.5f, 4, kNo, 2, 2}};
    const DisparityMap map{5, 1, {9, 9, 9, 9, 2}};
    EvaluationConfig config{.right_truth = &right};
    const DisparityEvaluation e = evaluate_disparity(map, truth, config);
    EXPECT_EQ(e.nonoccluded_pixels, 1);  // 3 disagrees, 4 is unknown in the right view
    EXPECT_DOUBLE_EQ(e.bad_nonoccluded_percent[2], 100);
}

TEST(Evaluation, EdgesCountWrongSidesAndUnknownPixels) {
    const auto step_at = [](int edge) {
        return make_map(20, 9, [=](int x, int) { return x < edge ? 10 : 20; });
    };
    const DisparityMap truth = step_at(10);
    // The windows of 7 columns that contain both 9 and 10 are those around 7 to 12.
    DisparityEvaluation e = evaluate_disparity(step_at(11), truth);
    EXPECT_EQ(e.edge_pixels, 6 * 9);
    EXPECT_DOUBLE_EQ(e.edge_wrong_percent, 100.0 / 6);
    EXPECT_EQ(e.edge_unknown_percent, 0);
    DisparityMap open = truth;
    for (int y = 0; y < 9; ++y) open.at(8, y) = open.at(2, y) = kNo;
    e = evaluate_disparity(open, truth);
    EXPECT_EQ(e.edge_wrong_percent, 0);
    EXPECT_DOUBLE_EQ(e.edge_unknown_percent, 100.0 / 6);
    EvaluationConfig config;
    config.discontinuity_px = 10;  // a step of 10 px is not above it
    EXPECT_EQ(evaluate_disparity(open, truth, config).edge_pixels, 0);
    EXPECT_EQ(evaluate_disparity(open, truth, config).edge_unknown_percent, 0);
}

TEST(Evaluation, RoughnessOfAChequeredPlane) {
    const auto plane = [](int x, int y) { return 20 + x / 8.0 + y / 16.0; };
    const DisparityMap truth = make_map(21, 17, plane);
    const DisparityMap chequered =
        make_map(21, 17, [&](int x, int y) { return plane(x, y) + ((x + y) % 2 ? 0.25 : -0.25); });
    DisparityEvaluation e = evaluate_disparity(chequered, truth);
    EXPECT_EQ(e.roughness_windows, 4 * 3);
    // 41 of 81 pixels are off by one amount and 40 by another: the plane is 1/81 of the amount
    // away from the middle.
    EXPECT_NEAR(e.roughness_px, 0.25 * std::sqrt(1 - 1 / (81.0 * 81)), 1e-12);
    EXPECT_EQ(evaluate_disparity(truth, truth).roughness_px, 0);

    DisparityMap lifted = truth;  // another plane is as smooth
    for (float& d : lifted.values) d += 5;
    EXPECT_NEAR(evaluate_disparity(lifted, truth).roughness_px, 0, 1e-6);
    DisparityMap holed = chequered;
    holed.at(0, 0) = kNo;
    EXPECT_EQ(evaluate_disparity(holed, truth).roughness_windows, 11);
    const DisparityMap flat = make_map(21, 17, [](int, int) { return 20; });
    e = evaluate_disparity(chequered, flat);
    EXPECT_EQ(e.roughness_windows, 0);
    EXPECT_EQ(e.roughness_px, 0);
}

// The definitions once more, pixel by pixel and without the program's shortcuts.
struct Oracle {
    const DisparityMap &map, &truth;
    float jump;

    bool in(int x, int y) const { return x >= 0 && x < truth.width && y >= 0 && y < truth.height; }
    bool known(int x, int y) const { return in(x, y) && std::isfinite(truth.at(x, y)); }

    bool jumps(int x, int y) const {
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
            if (known(x, y) && known(x + dx, y + dy) &&
                std::fabs(truth.at(x, y) - truth.at(x + dx, y + dy)) > jump)
                return true;
        return false;
    }

    // 0: no edge, 1: right side, 2: wrong side, 3: unknown
    int edge(int x, int y) const {
        bool near = false;
        float front = -1e9f, back = 1e9f;
        for (int ny = y - 3; ny <= y + 3; ++ny)
            for (int nx = x - 3; nx <= x + 3; ++nx) {
                near |= jumps(nx, ny);
                if (!known(nx, ny)) continue;
                front = std::max(front, truth.at(nx, ny));
                back = std::min(back, truth.at(nx, ny));
            }
        if (!near || !known(x, y) || front - back <= jump) return 0;
        if (!std::isfinite(map.at(x, y))) return 3;
        const float middle = (front + back) / 2;
        return (map.at(x, y) > middle) == (truth.at(x, y) > middle) ? 1 : 2;
    }

    bool nonoccluded(int x, int y) const {
        if (!known(x, y)) return false;
        const auto lands = [&](int from) { return from - std::lrint(truth.at(from, y)); };
        if (lands(x) < 0) return false;
        for (int other = 0; other < truth.width; ++other)
            if (known(other, y) && lands(other) == lands(x) && truth.at(other, y) > truth.at(x, y) + 1.01)
                return false;
        return true;
    }
};

TEST(Evaluation, AgreesWithTheDefinitions) {
    std::mt19937 random(5);
    for (int round = 0; round < 40; ++round) {
        const int width = 1 + static_cast<int>(random() % 40), height = 1 + static_cast<int>(random() % 24);
        const auto one_in = [&](unsigned n) { return random() % n == 0; };
        const int blocks = 2 + static_cast<int>(random() % 6);
        DisparityMap truth = make_map(width, height, [&](int x, int y) {
            return one_in(12) ? kNo : 3 + float((x / blocks * 7 + y / blocks * 3) % 5) + (x + y) * 0.25f;
        });
        truth.values[0] = 4;
        const DisparityMap map = make_map(width, height, [&](int x, int y) {
            const float t = truth.at(x, y);
            return one_in(6) || !std::isfinite(t) ? kNo : t + float(random() % 17) * 0.5f - 4 + 1.125f;
        });
        EvaluationConfig config{.discontinuity_px = round % 2 ? 1.0 : 2.0};
        const DisparityEvaluation e = evaluate_disparity(map, truth, config);
        const Oracle oracle{map, truth, static_cast<float>(config.discontinuity_px)};
        long long edges[4] = {}, visible = 0, bad = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                ++edges[oracle.edge(x, y)];
                const bool both = oracle.nonoccluded(x, y);
                visible += both;
                bad += both && !(std::fabs(map.at(x, y) - truth.at(x, y)) <= 1);
            }
        const long long all = edges[1] + edges[2] + edges[3];
        ASSERT_EQ(e.edge_pixels, all);
        ASSERT_EQ(e.nonoccluded_pixels, visible);
        ASSERT_NEAR(e.edge_wrong_percent, all ? 100.0 * edges[2] / all : 0, 1e-9);
        ASSERT_NEAR(e.edge_unknown_percent, all ? 100.0 * edges[3] / all : 0, 1e-9);
        ASSERT_NEAR(e.bad_nonoccluded_percent[1], visible ? 100.0 * bad / visible : 0, 1e-9);
    }
}

// Returns a pixel's deviation from a plane found by Cramer's rule on the normal
// equations, in absolute coordinates.
double deviation_from_plane(const DisparityMap& map, int left, int top, int x, int y) {
    double s[3][4] = {};
    for (int py = top; py < top + 9; ++py)
        for (int px = left; px < left + 9; ++px) {
            const double row[4] = {1, double(px), double(py), map.at(px, py)};
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 4; ++j) s[i][j] += row[i] * row[j];
        }
    const auto determinant = [&](int a, int b, int c) {
        return s[0][a] * (s[1][b] * s[2][c] - s[1][c] * s[2][b]) -
               s[0][b] * (s[1][a] * s[2][c] - s[1][c] * s[2][a]) +
               s[0][c] * (s[1][a] * s[2][b] - s[1][b] * s[2][a]);
    };
    const double all = determinant(0, 1, 2);
    return map.at(x, y) - (determinant(3, 1, 2) + determinant(0, 3, 2) * x + determinant(0, 1, 3) * y) / all;
}

TEST(Evaluation, RoughnessAgreesWithPlanesSolvedDirectly) {
    std::mt19937 random(11);
    const DisparityMap truth = make_map(
        45, 37, [](int x, int y) { return std::round(30 + 0.21 * x - 0.34 * y + (x > 30 ? 9 : 0)); });
    const DisparityMap map = make_map(45, 37, [&](int x, int y) {
        return random() % 900 == 0 ? kNo : truth.at(x, y) + float(random() % 100) * 0.0625f - 3;
    });
    double squares = 0;
    long long windows = 0;
    for (int top = 0; top + 9 <= 37; top += 4)
        for (int left = 0; left + 9 <= 45; left += 4) {
            double largest = 0, sum = 0, estimated = 0;
            bool whole = true;
            for (int y = top; y < top + 9; ++y)
                for (int x = left; x < left + 9; ++x) {
                    const double of_truth = deviation_from_plane(truth, left, top, x, y);
                    largest = std::max(largest, std::fabs(of_truth));
                    sum += of_truth * of_truth;
                    whole = whole && std::isfinite(map.at(x, y));
                    const double d = whole ? deviation_from_plane(map, left, top, x, y) : 0;
                    estimated += std::min(d * d, 4.0);
                }
            if (largest >= 0.9 || std::sqrt(sum / 81) >= 0.32 || !whole) continue;
            ++windows;
            squares += estimated;
        }
    const DisparityEvaluation e = evaluate_disparity(map, truth);
    ASSERT_GT(windows, 20);
    ASSERT_LT(windows, 70) << "some cross the step or have an unknown pixel";
    EXPECT_EQ(e.roughness_windows, windows);
    EXPECT_NEAR(e.roughness_px, std::sqrt(squares / 81 / windows), 1e-9);
}

TEST(Evaluation, RefusesOtherSizesAndEmptyTruth) {
    EXPECT_CONTAINS(test::error_of([] { evaluate_disparity({2, 1, {1, 2}}, {1, 1, {1}}); }), "2x1");
    EXPECT_CONTAINS(test::error_of([] { evaluate_disparity({1, 1, {1}}, {1, 1, {kNo}}); }), "no known pixel");
    EXPECT_CONTAINS(test::error_of([] {
                        const DisparityMap right{2, 1, {1, 2}};
                        EvaluationConfig config{.right_truth = &right};
                        evaluate_disparity({1, 1, {1}}, {1, 1, {1}}, config);
                    }),
                    "right view");
    EXPECT_CONTAINS(test::error_of(
                        [] {
                            EvaluationConfig config{.discontinuity_px = 0};
                            evaluate_disparity({1, 1, {1}}, {1, 1, {1}}, config);
                        },
                        ErrorKind::usage),
                    "above 0");
}

}  // namespace
}  // namespace hexrelief::evaluation
