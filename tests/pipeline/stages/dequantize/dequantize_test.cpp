#include "pipeline/stages/dequantize/dequantize.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "naive_dequantize.h"

namespace hexrelief::stages {
namespace {

using Surface = std::function<double(int, int)>;

DisparityMap sampled(int width, int height, const Surface& surface) {
    DisparityMap map{width, height, std::vector<float>(static_cast<std::size_t>(width) * height)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) map.at(x, y) = static_cast<float>(surface(x, y));
    return map;
}

DisparityMap rounded(DisparityMap map, double quantum_px) {
    for (float& d : map.values)
        if (DisparityMap::known(d)) d = static_cast<float>(std::nearbyint(d / quantum_px) * quantum_px);
    return map;
}

double rmse_inside(const DisparityMap& map, const DisparityMap& truth, int border) {
    double sum = 0;
    int count = 0;
    for (int y = border; y < map.height - border; ++y)
        for (int x = border; x < map.width - border; ++x, ++count)
            sum += std::pow(map.at(x, y) - truth.at(x, y), 2);
    return std::sqrt(sum / count);
}

// Returns a map with slanted surfaces, bumps, discontinuities of 2 px and more, holes, single pixels,
// and disparities of 0.
DisparityMap made_up(int width, int height, unsigned seed, double quantum_px) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0, 1);
    const double slope = share(random) - 0.5, wave = 3 * share(random);
    DisparityMap map = sampled(width, height, [&](int x, int y) {
        double d = 30 + slope * x + 0.1 * y + wave * std::sin(0.2 * x) * std::cos(0.15 * y);
        if (x > width / 3 && y > height / 4 && x < width / 2) d += 2 + 0.3 * y;
        return d;
    });
    for (float& d : map.values) {
        const double chance = share(random);
        if (chance < 0.01) d = kUnknownDisparity;
        if (chance > 0.995) d += 5;
        if (chance > 0.998) d = 0;
    }
    return rounded(map, quantum_px);
}

TEST(Dequantize, BringsARoundedPlaneBack) {
    for (const double quantum_px : {1.0, 0.25})
        for (const auto& [across, down] : {std::pair{0.11, 0.07}, {0.3, -0.21}, {-0.06, 0.04}, {0.7, 0.1}}) {
            const DisparityMap truth = sampled(160, 120, [&, a = across, b = down](int x, int y) {
                return 200 + quantum_px * (a * x + b * y);
            });
            const DisparityMap map = rounded(truth, quantum_px);
            EXPECT_GT(rmse_inside(map, truth, 8), 0.27 * quantum_px);
            EXPECT_LT(rmse_inside(dequantize(map, quantum_px, 2), truth, 8), 0.1 * quantum_px)
                << quantum_px << ' ' << across << ' ' << down;
        }
}

TEST(Dequantize, KeepsPlanesThatAreExact) {
    const DisparityMap map = sampled(70, 50, [](int x, int y) { return 10 + x + y; });
    const DisparityMap level = sampled(70, 50, [](int, int) { return 12; });
    EXPECT_LT(rmse_inside(dequantize(map, 1, 1), map, 0), 1e-4);
    EXPECT_EQ(dequantize(level, 1, 1).values, level.values);
}

TEST(Dequantize, KeepsAStepOfThreeQuanta) {
    const DisparityMap map = sampled(80, 60, [](int x, int) { return x < 40 ? 20 : 23; });
    EXPECT_EQ(dequantize(map, 1, 1).values, map.values);
}

// The surface stage cuts between neighbours that differ by more than 1 px.
TEST(Dequantize, KeepsTheDiscontinuitiesOfWholePixels) {
    for (unsigned seed = 0; seed < 5; ++seed) {
        const DisparityMap map = made_up(91, 67, seed, 1), smooth = dequantize(map, 1, 1);
        for (int y = 0; y < map.height; ++y)
            for (int x = 1; x < map.width; ++x)
                if (std::abs(map.at(x, y) - map.at(x - 1, y)) > 1) {
                    EXPECT_GT(std::abs(smooth.at(x, y) - smooth.at(x - 1, y)), 1) << x << ' ' << y;
                }
    }
}

TEST(Dequantize, SmoothsAcrossTheStepsOfAFloor) {
    const Surface floor_at = [](int, int y) { return 30 + 1.4 * y; };
    const DisparityMap truth = sampled(90, 80, floor_at), map = rounded(truth, 1);
    EXPECT_LT(rmse_inside(dequantize(map, 1, 1), truth, 8), 0.5 * rmse_inside(map, truth, 8));
}

TEST(Dequantize, StaysWithinHalfAQuantumAndLeavesUnknownAndZeroAlone) {
    for (const double quantum_px : {1.0, 1 / 3.0, 0.125}) {
        const DisparityMap map = made_up(123, 77, 7, quantum_px), smooth = dequantize(map, quantum_px, 1);
        for (std::size_t i = 0; i < map.values.size(); ++i) {
            const float before = map.values[i], after = smooth.values[i];
            if (!DisparityMap::known(before) || before == 0) {
                EXPECT_EQ(after, before);
            } else
                EXPECT_LT(std::abs(after - before), 0.5 * quantum_px);
            EXPECT_EQ(after > 0, before > 0);
        }
    }
}

TEST(Dequantize, GivesTheSameBytesOnAnyNumberOfThreads) {
    for (const auto& [width, height] : {std::pair{211, 97}, {64, 5}, {1, 40}, {3, 3}, {2, 1}}) {
        const DisparityMap map = made_up(width, height, 3, 1), one = dequantize(map, 1, 1);
        for (const int threads : {2, 3, 8}) EXPECT_EQ(dequantize(map, 1, threads).values, one.values);
    }
}

TEST(Dequantize, IsWhatTheOracleFinds) {
    for (unsigned seed = 0; seed < 20; ++seed)
        for (const double quantum_px : {1.0, 0.25}) {
            const int width = 1 + static_cast<int>(7 * seed % 97), height = 60 - static_cast<int>(3 * seed);
            const DisparityMap map = made_up(width, height, seed, quantum_px);
            const DisparityMap found = dequantize(map, quantum_px, 2),
                               expected = naive::dequantize(map, quantum_px);
            for (std::size_t i = 0; i < map.values.size(); ++i)
                if (DisparityMap::known(map.values[i])) {
                    ASSERT_NEAR(found.values[i], expected.values[i], 2e-4) << seed << ' ' << i;
                } else
                    ASSERT_EQ(found.values[i], expected.values[i]);
        }
}

}  // namespace
}  // namespace hexrelief::stages
