// Tests activation and extraction of points (Eq. 5, 6 and 7 of the paper) by their statistics. Seeds are
// fixed, so a passing test always passes; limits are the 99.99 % quantiles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesher/som/cell_matrix_step.h"
#include "mesher/som/philox_step.h"
#include "tests/mesher/densities.h"

namespace hexrelief::som {
namespace {

using namespace testing_mesher;

// Upper 0.01 % quantile of chi-square (Wilson and Hilferty).
double chi_square_limit(int degrees) {
    const double c = 2.0 / (9 * degrees);
    return degrees * std::pow(1 - c + 3.719 * std::sqrt(c), 3);
}

struct CellDistributions {
    step::CellGrid grid;
    std::vector<std::uint32_t> cumulative, sums;
    std::uint32_t most = 0;

    CellDistributions(const DensityMap& density, int co)
        : grid(step::make_cell_grid(density.width, density.height, co)), cumulative(density.values.size()) {
        const float largest = *std::max_element(density.values.begin(), density.values.end());
        const float scale = static_cast<float>((1u << step::weight_bits(co)) - 1) / largest;
        for (int cell = 0; cell < grid.columns * grid.rows; ++cell)
            sums.push_back(
                step::cumulate_weights(grid, cell, density.values.data(), scale, cumulative.data()));
        most = *std::max_element(sums.begin(), sums.end());
    }
};

struct Counts {
    std::vector<long long> pixels, cells;
    long long all = 0;
};

constexpr std::uint64_t kSeed = 11;

// Returns a random word. Word 0 decides how many points the cell extracts, word k + 1 belongs to draw k.
std::uint32_t random_word(int iteration, int cell, int word) {
    return step::philox(kSeed, cell, iteration, 0, word / 4).word[word % 4];
}

// Returns the points that `iterations` iterations extract.
Counts extract(const DensityMap& density, const CellDistributions& distributions, double delta,
               int iterations) {
    const int cells = static_cast<int>(distributions.sums.size());
    Counts counts{std::vector<long long>(density.values.size()), std::vector<long long>(cells)};
    for (int t = 0; t < iterations; ++t)
        for (int cell = 0; cell < cells; ++cell) {
            const std::uint64_t activity =
                step::cell_activity(distributions.sums[cell], distributions.most, delta);
            const int n = step::draw_count(activity, random_word(t, cell, 0));
            for (int k = 0; k < n; ++k) {
                const step::HalfPoint p =
                    step::extract_point(distributions.grid, cell, distributions.cumulative.data(),
                                        distributions.sums[cell], {k, n, random_word(t, cell, k + 1)});
                EXPECT_EQ(p.x % 2, 1) << "pixel centres are odd in half pixels";
                ++counts.pixels[static_cast<std::size_t>(p.y / 2) * density.width + p.x / 2];
                ++counts.cells[cell];
                ++counts.all;
            }
        }
    return counts;
}

// Checks Pearson's statistic of the counts against the density; classes with an expectation
// below 5 are pooled.
void expect_distribution(const DensityMap& density, const Counts& counts) {
    double sum = 0;
    for (const float v : density.values) sum += v;
    double statistic = 0, pooled_expected = 0, pooled_seen = 0;
    int degrees = -1;
    for (std::size_t i = 0; i < density.values.size(); ++i) {
        const double expected = density.values[i] / sum * static_cast<double>(counts.all);
        const auto seen = static_cast<double>(counts.pixels[i]);
        if (density.values[i] == 0) {
            EXPECT_EQ(counts.pixels[i], 0) << "pixel " << i << " has no density";
        }
        if (expected < 5) {
            pooled_expected += expected;
            pooled_seen += seen;
            continue;
        }
        statistic += (seen - expected) * (seen - expected) / expected;
        ++degrees;
    }
    if (pooled_expected > 5) {
        statistic += (pooled_seen - pooled_expected) * (pooled_seen - pooled_expected) / pooled_expected;
        ++degrees;
    }
    ASSERT_GT(degrees, 100);
    EXPECT_LT(statistic, chi_square_limit(degrees)) << degrees << " degrees of freedom";
}

// Eq. 6 and 7 together draw each pixel in proportion to its density: Eq. 5.
TEST(Extraction, FollowsTheDensityOverTheWholeImage) {
    const DensityMap density = noise_density(43, 37, 5);
    for (const double delta : {1.0, 4.0}) {
        const Counts counts = extract(density, CellDistributions(density, 10), delta, 3000);
        ASSERT_GT(counts.all, 20000);
        expect_distribution(density, counts);
    }
}

TEST(Extraction, FollowsTheDensityWithinACell) {
    DensityMap density = noise_density(20, 16, 9);
    density.values[0] = 0;
    density.values.back() = 1;
    expect_distribution(density, extract(density, CellDistributions(density, 20), 1, 40000));
}

// Draws at even steps over the distribution give each pixel its share, to within one step.
TEST(Extraction, SharesAreExact) {
    DensityMap density = flat_density(4, 2);
    density.values = {0, 1, 2, 0, 5, 0, 0.5f, 3};
    const CellDistributions distributions(density, 4);
    const int draws = 23000;
    std::vector<int> seen(8);
    for (int i = 0; i < draws; ++i) {
        const auto uniform = static_cast<std::uint32_t>(4294967296.0 * (i + 0.5) / draws);
        const step::HalfPoint p = step::extract_point(distributions.grid, 0, distributions.cumulative.data(),
                                                      distributions.sums[0], {0, 1, uniform});
        ++seen[(p.y / 2) * 4 + p.x / 2];
    }
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(seen[i], draws * density.values[i] / 11.5, 2) << "pixel " << i;
}

TEST(Extraction, EndsOfTheDistributionHitTheFirstAndLastPixelWithDensity) {
    DensityMap density = flat_density(3, 3, 0);
    density.values[2] = 1;
    density.values[7] = 0.25f;
    const CellDistributions distributions(density, 3);
    const auto draw = [&](std::uint32_t uniform) {
        const step::HalfPoint p = step::extract_point(distributions.grid, 0, distributions.cumulative.data(),
                                                      distributions.sums[0], {0, 1, uniform});
        return (p.y / 2) * 3 + p.x / 2;
    };
    EXPECT_EQ(draw(0), 2);
    EXPECT_EQ(draw(0xFFFFFFFFu), 7);
}

// Eq. 6: a cell extracts S_i / max S x delta points an iteration on average; the densest cell exactly delta,
// if that is an integer.
TEST(Activation, ExpectedDraws) {
    const DensityMap density = bumps_density(80, 60);
    const CellDistributions distributions(density, 20);
    const int iterations = 4000;
    for (const double delta : {0.25, 1.0, 3.0}) {
        const Counts counts = extract(density, distributions, delta, iterations);
        for (std::size_t cell = 0; cell < distributions.sums.size(); ++cell) {
            const double expected =
                static_cast<double>(distributions.sums[cell]) / distributions.most * delta;
            const double fraction = expected - std::floor(expected);
            const double deviation = std::sqrt(fraction * (1 - fraction) * iterations);
            EXPECT_NEAR(static_cast<double>(counts.cells[cell]), expected * iterations, 4 * deviation + 1e-6)
                << "cell " << cell << ", delta " << delta;
        }
    }
}

TEST(Activation, NoDensityNoDraw) {
    EXPECT_EQ(step::cell_activity(0, 1000, 4.0), 0u);
    EXPECT_EQ(step::draw_count(0, 0xFFFFFFFFu), 0);
    EXPECT_EQ(step::draw_count(step::cell_activity(1000, 1000, 1.0), 0), 1);
    EXPECT_EQ(step::draw_count(step::cell_activity(1000, 1000, 1.0), 0xFFFFFFFFu), 1);
}

// The sum of a full cell of the densest pixels must fit into 32 bits, whatever its size.
TEST(Extraction, CellSumsNeverWrap) {
    for (const int co : {1, 2, 10, 15, 16, 20, 64, 257, 1000}) {
        const DensityMap density = flat_density(std::min(co, 300), std::min(co, 300), 0.3f);
        const CellDistributions distributions(density, co);
        for (std::size_t i = 1; i < distributions.cumulative.size(); ++i)
            ASSERT_GT(distributions.cumulative[i], distributions.cumulative[i - 1]) << "co " << co;
        const std::uint64_t most =
            static_cast<std::uint64_t>(co) * co * ((1ull << step::weight_bits(co)) - 1);
        EXPECT_LT(most, 1ull << 32) << "co " << co;
    }
}

}  // namespace
}  // namespace hexrelief::som
