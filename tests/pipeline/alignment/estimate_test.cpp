#include "pipeline/alignment/estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace hexrelief::alignment {
namespace {

constexpr double kWidth = 1024, kHeight = 682;

// Numbers from -1 to 1 in an order that looks like chance.
class Scatter {
  public:
    double next() {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return static_cast<double>(state_ >> 33) / (1u << 30) - 1;
    }

  private:
    std::uint64_t state_ = 1;
};

// Where a camera sees a place of a front of a house, 10 away: a and b along it, `depth` times as far.
Point seen(double a, double b, double depth, double camera_x, double camera_y) {
    const double x = depth * a - camera_x, y = depth * b - camera_y, z = depth * (10 + 0.2 * a);
    return {kWidth / 2 + kWidth * x / z, kHeight / 2 + kWidth * y / z};
}

// Two cameras, the second one above the first and `aside`, look at a front of a house. Three of ten windows
// are taken for the next ones in their rows; few things stand out from the front.
std::vector<Match> matches_of_house(double aside, bool has_repetitions) {
    Scatter scatter;
    std::vector<Match> matches;
    for (int i = 0; i < 450; ++i) {
        const double a = 4 * scatter.next(), b = 2.5 * scatter.next();
        const double depth = i % 7 == 0 ? 0.95 + 0.05 * scatter.next() : 1;
        const double next = has_repetitions && i % 10 < 3 ? 1.2 : 0;
        Match match{seen(a, b, depth, 0, 0), seen(a + next, b, depth, aside, -1)};
        for (double* at : {&match.left.x, &match.left.y, &match.right.x, &match.right.y})
            *at += 0.2 * scatter.next();
        matches.push_back(match);
    }
    return matches;
}

TEST(Estimate, RepeatedPatternsAlongRowsDoNotDecideWhichWayTheCamerasStand) {
    ThreadPool pool(2);
    for (const double aside : {-0.5, 0.8}) {
        const Estimate estimate = estimate_views({kWidth, kHeight, kWidth}, matches_of_house(aside, true),
                                                 {.is_focal_known = true}, pool);
        EXPECT_TRUE(estimate.is_quarter_turned);
        // The true matches of the same places lie on their rows.
        std::vector<double> rows;
        for (Match match : matches_of_house(aside, false)) {
            for (Point* p : {&match.left, &match.right}) *p = {p->y, kWidth - 1 - p->x};
            rows.push_back(std::fabs(
                estimate.views().row_offset(estimate.is_exchanged ? Match{match.right, match.left} : match)));
        }
        EXPECT_LT(median(rows), 0.5) << aside;
    }
}

TEST(Matches, AreSupportedByNeighboursThatShiftAlike) {
    std::vector<Match> matches;
    std::vector<Point> shifts;
    for (int i = 0; i < 100; ++i) {
        const Point left{10.0 * (i % 10), 10.0 * (i / 10)};
        // A slanted surface, two of whose points are taken for others.
        shifts.push_back({20 + 0.05 * left.x + (i == 33 ? 9 : 0), i == 66 ? -9.0 : 1.0});
        matches.push_back({left, {left.x + shifts.back().x, left.y + shifts.back().y}});
    }
    std::vector<std::size_t> places = supported_by_neighbours(matches, shifts);
    std::sort(places.begin(), places.end());
    EXPECT_EQ(places.size(), 98u);
    for (const std::size_t alone : {33u, 66u}) EXPECT_FALSE(std::ranges::binary_search(places, alone));
}

}  // namespace
}  // namespace hexrelief::alignment
