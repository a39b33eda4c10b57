#include "pipeline/stages/density.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/pipeline/stages/expect_error.h"

namespace hexrelief {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

DisparityMap row(std::vector<float> values) {
    return {static_cast<int>(values.size()), 1, std::move(values)};
}

TEST(Density, IsTheCubeOfTheShareOfTheLargest) {
    DensityConfig config;
    config.background_method = BackgroundMethod::none;
    const DensityMap density = compute_density(row({10, 20, 40, kUnknownDisparity}), config);
    EXPECT_EQ(density.values, (std::vector<float>{0.25f * 0.25f * 0.25f, 0.125f, 1, 0}));
    EXPECT_EQ(density.background_px, 0);
}

TEST(Density, TakesAnyExponent) {
    DensityConfig config;
    config.background_method = BackgroundMethod::none;
    for (const double exponent : {0.0, 0.5, 1.0, 2.0, 2.5, 8.0}) {
        config.exponent = exponent;
        const DensityMap density = compute_density(row({3, 7, 9}), config);
        EXPECT_FLOAT_EQ(density.values[0], static_cast<float>(std::pow(3.0 / 9.0, exponent)));
        EXPECT_FLOAT_EQ(density.values[1], static_cast<float>(std::pow(7.0 / 9.0, exponent)));
        EXPECT_EQ(density.values[2], 1);
    }
}

TEST(Density, RemovesBackgroundBelowAShareOfTheLargest) {
    const DensityMap density = compute_density(row({9.99f, 10, 40}), {});
    EXPECT_EQ(density.values[0], 0);
    EXPECT_GT(density.values[1], 0);
    EXPECT_EQ(density.background_px, 10);
}

TEST(Density, RemovesBackgroundBelowAThreshold) {
    DensityConfig config;
    config.background_method = BackgroundMethod::threshold_px;
    config.background_threshold_px = 20;
    const DensityMap density = compute_density(row({19, 20, 40}), config);
    EXPECT_EQ(density.values[0], 0);
    EXPECT_EQ(density.values[1], 0.125f);
    EXPECT_EQ(density.background_px, 20);
}

TEST(Density, OtsuSplitsTwoModesBetweenThem) {
    std::mt19937 random(7);
    DisparityMap map{100, 100, std::vector<float>(10000)};
    for (std::size_t i = 0; i < map.values.size(); ++i) {
        const float noise = static_cast<float>(random() % 1000) / 250;  // 0..4
        map.values[i] = i % 5 == 0 ? kUnknownDisparity : (i % 3 == 0 ? 50 + noise : 12 + noise);
    }
    DensityConfig config;
    config.background_method = BackgroundMethod::otsu;
    const DensityMap density = compute_density(map, config);
    EXPECT_NEAR(density.background_px, 33, 3);  // the middle of the empty stretch from 16 to 50
    for (std::size_t i = 0; i < map.values.size(); ++i) {
        EXPECT_EQ(density.values[i] > 0, DisparityMap::known(map.values[i]) && map.values[i] > 33);
    }
}

TEST(Density, OtsuKeepsAllOfAConstantMap) {
    DensityConfig config;
    config.background_method = BackgroundMethod::otsu;
    EXPECT_EQ(compute_density(row({8, 8, 8}), config).values, (std::vector<float>{1, 1, 1}));
}

TEST(Density, CountsZeroAndNegativeAsBackgroundAndUnknownAsNothing) {
    DensityConfig config;
    config.background_method = BackgroundMethod::none;
    config.floor = 0.1;
    const DensityMap density =
        compute_density(row({-5, 0, kNaN, kUnknownDisparity, -kUnknownDisparity, 4}), config);
    EXPECT_EQ(density.values, (std::vector<float>{0.1f, 0.1f, 0, 0, 0, 1}));
}

TEST(Density, FloorLiftsWhatIsKnown) {
    DensityConfig config;
    config.floor = 0.05;
    const DensityMap density = compute_density(row({1, 12, 40, kUnknownDisparity}), config);
    EXPECT_EQ(density.values, (std::vector<float>{0.05f, 0.05f, 1, 0}));
}

TEST(Density, OfNothingIsZero) {
    for (const DisparityMap& map : {row({0, 0}), row({-1, kUnknownDisparity}), row({kUnknownDisparity})}) {
        for (const float value : compute_density(map, {}).values) EXPECT_EQ(value, 0);
    }
}

TEST(Density, DoesNotChangeWithScaleOrMirror) {
    std::mt19937 random(3);
    DisparityMap map{40, 30, std::vector<float>(1200)}, twice = map, mirrored = map;
    for (int i = 0; i < 1200; ++i) {
        map.values[i] = random() % 7 == 0 ? kUnknownDisparity : static_cast<float>(random() % 4096) / 64;
        twice.values[i] = 2 * map.values[i];
        mirrored.values[i / 40 * 40 + 39 - i % 40] = map.values[i];
    }
    const DensityMap density = compute_density(map, {}), same = compute_density(twice, {}),
                     flipped = compute_density(mirrored, {});
    EXPECT_EQ(density.values, same.values);
    for (int i = 0; i < 1200; ++i) {
        EXPECT_EQ(density.values[i], flipped.values[i / 40 * 40 + 39 - i % 40]);
        EXPECT_TRUE(density.values[i] >= 0 && density.values[i] <= 1);
    }
}

TEST(Density, RefusesImpossibleParameters) {
    DensityConfig config;
    config.exponent = -1;
    expect_error(ErrorKind::usage, "density.exponent", [&] { compute_density(row({1}), config); });
    config = {};
    config.background_fraction = 1.5;
    expect_error(ErrorKind::usage, "density.background.fraction", [&] { compute_density(row({1}), config); });
    config = {};
    config.floor = std::nan("");
    expect_error(ErrorKind::usage, "density.floor", [&] { compute_density(row({1}), config); });
}

}  // namespace
}  // namespace hexrelief
