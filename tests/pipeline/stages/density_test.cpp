#include "pipeline/stages/density.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "tests/expect_error.h"

namespace hexrelief::stages {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

DisparityMap row(std::vector<float> values) {
    return {static_cast<int>(values.size()), 1, std::move(values)};
}

TEST(Density, IsTheCubeOfTheShareOfTheLargest) {
    DensityConfig config{.background_method = BackgroundMethod::none, .floor = 0};
    const DensityMap density = compute_density(row({10, 20, 40, kUnknownDisparity}), config);
    EXPECT_EQ(density.values, (std::vector<float>{0.25f * 0.25f * 0.25f, 0.125f, 1, 0}));
    EXPECT_EQ(density.background_px, 0);
}

TEST(Density, TakesAnyExponent) {
    DensityConfig config{.background_method = BackgroundMethod::none, .floor = 0};
    for (const double exponent : {0.0, 0.5, 1.0, 2.0, 2.5, 8.0}) {
        config.exponent = exponent;
        const DensityMap density = compute_density(row({3, 7, 9}), config);
        EXPECT_FLOAT_EQ(density.values[0], static_cast<float>(std::pow(3.0 / 9.0, exponent)));
        EXPECT_FLOAT_EQ(density.values[1], static_cast<float>(std::pow(7.0 / 9.0, exponent)));
        EXPECT_EQ(density.values[2], 1);
    }
}

// Returns a scene; `scale` enlarges the image and the disparities.
DisparityMap scene(int scale, const std::function<double(double x, double y)>& disparity) {
    DisparityMap map{160 * scale, 120 * scale, {}};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            map.values.push_back(static_cast<float>(scale * disparity((x + 0.5) / scale, (y + 0.5) / scale)));
    return map;
}

double far_wall(double x, double) {
    return 4 + 0.02 * x;
}

// A floor that extends from the lower edge to the farthest distance.
double floor_to_the_back(double, double y) {
    return 2 + 0.5 * std::max(0.0, y - 20);
}

bool on_object(double x, double y) {
    return std::hypot(x - 80, y - 60) < 30;
}

double object_or(double behind, double x, double y) {
    return on_object(x, y) ? 50 + 0.1 * x : behind;
}

TEST(Density, ByFractionRemovesWhatIsBelowAShareOfTheScale) {
    DensityConfig config{.background_method = BackgroundMethod::fraction, .floor = 0};
    const DensityMap density = compute_density(row({9.99f, 10, 40}), config);
    EXPECT_EQ(density.values[0], 0);
    EXPECT_GT(density.values[1], 0);
    EXPECT_EQ(density.background_px, 10);
}

TEST(Density, AutomaticCutsAnObjectOutOfItsFarWall) {
    for (const int scale : {1, 2, 4}) {
        const DisparityMap map =
            scene(scale, [](double x, double y) { return object_or(far_wall(x, y), x, y); });
        const DensityMap density = compute_density(map, {.floor = 0});
        for (int y = 0; y < map.height; ++y)
            for (int x = 0; x < map.width; ++x)
                ASSERT_EQ(density.at(x, y) > 0, on_object((x + 0.5) / scale, (y + 0.5) / scale))
                    << x << ' ' << y;
    }
}

TEST(Density, AutomaticDoesNotCutThroughSurfaces) {
    for (const int scale : {1, 2, 4}) {
        const DisparityMap maps[] = {
            scene(scale, floor_to_the_back), scene(scale, [](double x, double) { return 2 + 0.4 * x; }),
            scene(scale, [](double x, double y) { return object_or(floor_to_the_back(x, y), x, y); }),
            scene(scale, [](double, double y) { return std::round(floor_to_the_back(0, y)); })};
        for (const DisparityMap& map : maps) {
            const DensityMap density = compute_density(map, {});
            EXPECT_EQ(density.background_px, 0);
            EXPECT_GT(*std::min_element(density.values.begin(), density.values.end()), 0);
        }
    }
}

// Two planes separated by a step of a third of the nearer one's disparity, like two sheets of paper.
TEST(Density, AutomaticKeepsWhatIsNotFarBehind) {
    const DisparityMap map = scene(1, [](double x, double y) {
        if (x > 100) return 40.0;
        return y < 60 ? 8.0 : 12.0;
    });
    EXPECT_EQ(compute_density(map, {}).background_px, 0);
}

// A scrap in front of everything, such as a wrong patch, does not make the rest background.
TEST(Density, AutomaticNeverLeavesNextToNothing) {
    const auto scrap = [](double radius) {
        return scene(1, [=](double x, double y) {
            return std::hypot(x - 80, y - 60) < radius ? 50.0 : far_wall(x, y);
        });
    };
    EXPECT_EQ(compute_density(scrap(20), {}).background_px, 0);  // 7 % of the picture
    EXPECT_GT(compute_density(scrap(30), {}).background_px, 8);  // 15 %
}

// Unknown pixels by themselves form no border, neither in a floor full of holes nor across a whole floor.
TEST(Density, AutomaticLooksAcrossUnknownPixels) {
    std::mt19937 random(5);
    DisparityMap sparse = scene(1, floor_to_the_back), band = sparse;
    for (float& d : sparse.values)
        if (random() % 10 < 7) d = kUnknownDisparity;
    for (int y = 40; y < 60; ++y)
        for (int x = 0; x < band.width; ++x) band.at(x, y) = kUnknownDisparity;
    EXPECT_EQ(compute_density(sparse, {}).background_px, 0);
    EXPECT_EQ(compute_density(band, {}).background_px, 0);
    // Pixels that only the left camera sees are unknown; the gap is as wide as the step in disparity.
    DisparityMap object = scene(1, [](double x, double y) {
        const bool hidden = !on_object(x, y) && on_object(x + 40, y);
        return hidden ? kUnknownDisparity : object_or(far_wall(x, y), x, y);
    });
    EXPECT_GT(compute_density(object, {}).background_px, 8);
}

// The only border lies between the columns of two threads, once with unknown pixels on it, and has no
// step in depth, so nothing is removed. If it were missed, there would be no border at all, and the far
// side would be removed.
TEST(Density, BordersBetweenThreadsCount) {
    for (const int unknown : {0, 3}) {
        DisparityMap map{100, 20, std::vector<float>(2000, 11.0f)};
        for (int y = 0; y < map.height; ++y) {
            for (int x = 50; x < map.width; ++x) map.at(x, y) = 9;
            for (int x = 50 - unknown; x < 50 + unknown; ++x) map.at(x, y) = kUnknownDisparity;
            for (int x = 0; x < 10; ++x) map.at(x, y) = 40;
        }
        for (const int threads : {1, 2, 3, 4, 10})
            EXPECT_EQ(compute_density(map, {}, threads).background_px, 0) << threads << ' ' << unknown;
    }
}

TEST(Density, SameForAnyNumberOfThreads) {
    std::mt19937 random(7);
    DisparityMap map = scene(1, [](double x, double y) { return object_or(far_wall(x, y), x, y); });
    for (float& d : map.values)
        if (random() % 5 == 0) d = kUnknownDisparity;
    const DensityMap one = compute_density(map, {}, 1);
    EXPECT_GT(one.background_px, 8);
    for (const int threads : {2, 3, 7}) {
        const DensityMap some = compute_density(map, {}, threads);
        EXPECT_EQ(some.values, one.values) << threads;
        EXPECT_EQ(some.background_px, one.background_px);
    }
}

TEST(Density, AFewWrongPixelsDoNotMoveTheScale) {
    const DisparityMap map = scene(1, [](double x, double y) { return object_or(far_wall(x, y), x, y); });
    DisparityMap wrong = map;
    for (int i = 0; i < 30; ++i) wrong.values[std::size_t(i) * 631] = 500;  // 0.16 % of all pixels
    const DensityMap density = compute_density(map, {}), same = compute_density(wrong, {});
    EXPECT_NEAR(same.background_px, density.background_px, 0.02 * density.background_px);
    EXPECT_LE(*std::max_element(same.values.begin(), same.values.end()), 1);
    for (std::size_t i = 0; i < map.values.size(); ++i)
        if (map.values[i] == wrong.values[i]) {
            EXPECT_NEAR(same.values[i], density.values[i], 0.05);
        }
    DensityConfig largest{.scale_percentile = 100, .background_method = BackgroundMethod::fraction};
    EXPECT_EQ(compute_density(wrong, largest).background_px, 125);
}

// A patch of less than 0.5 % of the picture, however near, neither sets the scale nor makes the rest
// background.
TEST(Density, ASmallPatchDoesNotSetTheScale) {
    const auto with_patch = [](double radius, double nearness) {
        return scene(1, [=](double x, double y) {
            return std::hypot(x - 20, y - 20) < radius ? nearness : object_or(far_wall(x, y), x, y);
        });
    };
    const DensityMap right = compute_density(with_patch(0, 0), {});
    EXPECT_GT(right.background_px, 8);
    for (const double nearness : {100.0, 400.0}) {
        const DensityMap small = compute_density(with_patch(5, nearness), {});  // 0.4 %
        EXPECT_NEAR(small.background_px, right.background_px, 0.05 * right.background_px) << nearness;
        EXPECT_NEAR(small.at(80, 60), right.at(80, 60), 0.1) << nearness;
    }
    DensityConfig fraction;
    fraction.background_method = BackgroundMethod::fraction;
    EXPECT_EQ(compute_density(with_patch(5, 400), fraction).background_px, 100) << "as it was asked for";
    DisparityMap half_known = with_patch(6, 400);  // 0.6 % of the picture, 1.2 % of what is known
    for (int y = 0; y < half_known.height; ++y)
        for (int x = 100; x < half_known.width; ++x) half_known.at(x, y) = kUnknownDisparity;
    EXPECT_EQ(
        find_density_scale({1,
                            [&](const auto& take) {
                                take(0, {0, 0, half_known.width, half_known.height, half_known.values.data(),
                                         static_cast<std::size_t>(half_known.width)});
                            }},
                           {})
            .scale_px,
        400)
        << "of the picture";
}

TEST(Density, RemovesBackgroundBelowAThreshold) {
    DensityConfig config{
        .background_method = BackgroundMethod::threshold_px, .background_threshold_px = 20, .floor = 0};
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
    DensityConfig config{.background_method = BackgroundMethod::otsu, .floor = 0};
    const DensityMap density = compute_density(map, config);
    EXPECT_NEAR(density.background_px, 33, 3);  // the middle of the empty stretch from 16 to 50
    for (std::size_t i = 0; i < map.values.size(); ++i)
        EXPECT_EQ(density.values[i] > 0, DisparityMap::known(map.values[i]) && map.values[i] > 33);
}

TEST(Density, OtsuKeepsAllOfAConstantMap) {
    DensityConfig config{.background_method = BackgroundMethod::otsu};
    EXPECT_EQ(compute_density(row({8, 8, 8}), config).values, (std::vector<float>{1, 1, 1}));
}

TEST(Density, CountsZeroAndNegativeAsBackgroundAndUnknownAsNothing) {
    const DensityMap density = compute_density(row({-5, 0, kNaN, kUnknownDisparity, -kUnknownDisparity, 4}),
                                               {.background_method = BackgroundMethod::none, .floor = 0.1});
    EXPECT_EQ(density.values, (std::vector<float>{0.1f, 0.1f, 0, 0, 0, 1}));
}

TEST(Density, FloorLiftsWhatIsKnown) {
    const DensityMap density = compute_density(row({1, 12, 40, kUnknownDisparity}), {.floor = 0.05});
    EXPECT_EQ(density.values, (std::vector<float>{0.05f, 0.05f, 1, 0}));
}

TEST(Density, OfNothingIsZero) {
    for (const DisparityMap& map : {row({0, 0}), row({-1, kUnknownDisparity}), row({kUnknownDisparity})})
        for (const float value : compute_density(map, {}).values) EXPECT_EQ(value, 0);
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
    DensityConfig config{.exponent = -1};
    EXPECT_CONTAINS(test::error_of([&] { compute_density(row({1}), config); }, ErrorKind::usage),
                    "density.exponent");
    config = {};
    config.background_fraction = 1.5;
    EXPECT_CONTAINS(test::error_of([&] { compute_density(row({1}), config); }, ErrorKind::usage),
                    "density.background.fraction");
    config = {};
    config.scale_percentile = 100.5;
    EXPECT_CONTAINS(test::error_of([&] { compute_density(row({1}), config); }, ErrorKind::usage),
                    "density.scale_percentile");
    config = {};
    config.floor = std::nan("");
    EXPECT_CONTAINS(test::error_of([&] { compute_density(row({1}), config); }, ErrorKind::usage),
                    "density.floor");
}

}  // namespace
}  // namespace hexrelief::stages
