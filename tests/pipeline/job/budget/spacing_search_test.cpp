// Tests search_spacing() with figures given by formulas.
#include "pipeline/job/budget/budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace hexrelief::job {
namespace {

struct Outcome {
    std::optional<SpacingFound> found;
    SpacingFound nearest;
    std::vector<double> tried;
};

Outcome search(const SpacingSearch& search, const SpacingFigure& figure) {
    Outcome run;
    run.found = search_spacing(
        search,
        [&](double spacing_px) {
            run.tried.push_back(spacing_px);
            return figure(spacing_px);
        },
        run.nearest);
    return run;
}

std::optional<double> vertices(double spacing_px) {  // of a lattice over 900 x 750
    return std::round(900 / spacing_px) * std::round(750 / spacing_px);
}
std::optional<double> bytes(double spacing_px) {  // with a texture of constant size, and some unsteadiness
    return 20000 + 5e6 * std::pow(spacing_px, -1.6) * (1 + 0.02 * std::sin(40 * spacing_px));
}
std::optional<double> error(double spacing_px) {
    return 0.05 + 0.04 * std::pow(spacing_px, 1.2);
}

TEST(SpacingSearch, FinestLatticeWithinTheVertices) {
    for (const double limit : {30.0, 500.0, 5000.0, 18000.0, 100000.0}) {
        const Outcome run = search({limit, -2, 6, 2, 200}, vertices);
        ASSERT_TRUE(run.found) << limit;
        EXPECT_LE(run.found->value, limit);
        EXPECT_EQ(run.found->value, *vertices(run.found->spacing_px));
        EXPECT_LE(run.found->solves, 12);
        EXPECT_EQ(run.found->solves, static_cast<int>(run.tried.size()));
        // A lattice that is 3 % finer in each direction would break the limit, or nearly.
        EXPECT_GT(*vertices(run.found->spacing_px * 0.97), 0.97 * limit) << limit;
    }
}

TEST(SpacingSearch, BytesWithAConstantPart) {
    for (const double limit : {22000.0, 40000.0, 200000.0, 1e6}) {
        const Outcome run = search({limit, -1.6, 6, 2, 200}, bytes);
        ASSERT_TRUE(run.found) << limit;
        EXPECT_LE(run.found->value, limit);
        EXPECT_GT(run.found->value, 0.9 * limit) << limit;
    }
}

TEST(SpacingSearch, CoarsestLatticeWithinTheError) {
    for (const double limit : {0.15, 0.4, 2.0}) {
        const Outcome run = search({limit, 0.8, 6, 2, 200}, error);
        ASSERT_TRUE(run.found) << limit;
        EXPECT_LE(run.found->value, limit);
        EXPECT_GT(run.found->value, 0.95 * limit) << limit;
        EXPECT_LE(run.found->solves, 8);
    }
}

TEST(SpacingSearch, ALimitThatEverythingKeepsEndsAtTheRange) {
    const Outcome fine = search({1e9, -2, 6, 2, 200}, vertices);
    ASSERT_TRUE(fine.found);
    EXPECT_EQ(fine.found->spacing_px, 2);
    const Outcome coarse = search({1e9, 0.8, 6, 2, 200}, error);
    ASSERT_TRUE(coarse.found);
    EXPECT_EQ(coarse.found->spacing_px, 200);
}

TEST(SpacingSearch, ALimitOutOfReachSaysHowNearItCame) {
    const Outcome few = search({19999, -1.6, 6, 2, 200}, bytes);
    EXPECT_FALSE(few.found);
    EXPECT_EQ(few.nearest.spacing_px, 200);
    EXPECT_EQ(few.nearest.value, *bytes(200));
    const Outcome exact = search({0.1, 0.8, 6, 2, 200}, error);
    EXPECT_FALSE(exact.found);
    EXPECT_EQ(exact.nearest.spacing_px, 2);
    EXPECT_EQ(exact.nearest.solves, static_cast<int>(exact.tried.size()));
}

TEST(SpacingSearch, KeepsOffSpacingsThatLeaveNoMesh) {
    const auto some = [](double spacing_px) { return spacing_px > 31 ? std::nullopt : error(spacing_px); };
    const Outcome run = search({5, 0.8, 6, 2, 200}, some);
    ASSERT_TRUE(run.found);
    EXPECT_LE(run.found->spacing_px, 31);
    EXPECT_GT(run.found->spacing_px, 25);
    const Outcome none = search({5, 0.8, 6, 2, 200}, [](double) { return std::nullopt; });
    EXPECT_FALSE(none.found);
    EXPECT_EQ(none.nearest.value, 0);
}

TEST(SpacingSearch, SpacingsAreShortNumbers) {
    for (const double spacing_px : search({777, -2, 6, 2, 200}, vertices).tried)
        EXPECT_EQ(spacing_px, std::round(spacing_px * 100) / 100);
}

}  // namespace
}  // namespace hexrelief::job
