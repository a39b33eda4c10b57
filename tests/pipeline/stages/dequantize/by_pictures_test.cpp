#include "pipeline/stages/dequantize/dequantize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace hexrelief::stages {
namespace {

using Surface = std::function<double(int, int)>;

constexpr int kWidth = 240, kHeight = 160, kStep = 140;

double bent(int x, int y) {
    return 6 + 0.01 * x + 0.5 * std::sin(0.05 * x) * std::sin(0.04 * y);
}
double stepped(int x, int y) {
    return x < kStep ? bent(x, y) : bent(x, y) + 8;
}

// A pattern without an end, in levels; flat within the square.
struct Pattern {
    bool has_wall = false;
    static bool is_wall(double x, double y) { return std::abs(x - 70) < 24 && std::abs(y - 80) < 24; }

    double at(double x, double y) const {
        if (has_wall && is_wall(x, y)) return 120;
        return 120 + 40 * std::sin(0.9 * x + 2 * std::sin(0.31 * y)) + 25 * std::sin(0.37 * x - 0.8 * y);
    }
};

// Pictures of a surface: the pattern is the left one.
StereoPair pictures_of(const Surface& surface, const Pattern& pattern) {
    StereoPair pair;
    for (Image* const image : {&pair.left, &pair.right}) *image = {kWidth, kHeight, 1, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            double seen = x;  // the nearest column of the left picture that the right one shows here
            for (int k = 0; k < kWidth; ++k) {
                const double from = k - surface(k, y), to = k + 1 - surface(k + 1, y);
                if (from <= x && x < to) seen = k + (x - from) / (to - from);
            }
            pair.left.pixels.push_back(static_cast<std::uint8_t>(std::lround(pattern.at(x, y))));
            pair.right.pixels.push_back(static_cast<std::uint8_t>(std::lround(pattern.at(seen, y))));
        }
    return pair;
}

DisparityMap map_of(const Surface& surface, double noise_px) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal(0, 1);
    DisparityMap map{kWidth, kHeight, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            map.values.push_back(static_cast<float>(surface(x, y) + noise_px * normal(random)));
    map.origins.assign(map.values.size(), PixelOrigin::matched);
    return map;
}

double rmse_px(const DisparityMap& map, const Surface& surface, const std::function<bool(int, int)>& counts) {
    double sum = 0;
    int count = 0;
    for (int y = 10; y < kHeight - 10; ++y)
        for (int x = 24; x < kWidth - 10; ++x) {
            if (!counts(x, y)) continue;
            sum += std::pow(map.at(x, y) - surface(x, y), 2);
            ++count;
        }
    return std::sqrt(sum / count);
}

TEST(ByPictures, FindsTheSurfaceUnderNoise) {
    const auto all = [](int, int) { return true; };
    const DisparityMap noisy = map_of(bent, 0.2);
    const DisparityMap refined = refine_by_pictures(noisy, pictures_of(bent, {}), 2);
    EXPECT_LT(rmse_px(refined, bent, all), 0.25 * rmse_px(noisy, bent, all));
}

TEST(ByPictures, ABareWallIsTheSurfaceThroughWhatIsBesideIt) {
    const Pattern pattern{true};
    const auto is_inside = [](int x, int y) {
        return Pattern::is_wall(x - 6, y - 6) && Pattern::is_wall(x + 6, y + 6);
    };
    DisparityMap map = map_of(bent, 0.05);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            if (is_inside(x, y)) map.at(x, y) += y < 80 ? 3 : -2;
    const DisparityMap refined = refine_by_pictures(map, pictures_of(bent, pattern), 2);
    EXPECT_GT(rmse_px(map, bent, is_inside), 2);
    EXPECT_LT(rmse_px(refined, bent, is_inside), 0.4);
}

TEST(ByPictures, AStepStaysAndASpeckDoesNot) {
    DisparityMap map = map_of(stepped, 0.05);
    map.at(80, 60) += 5;
    const DisparityMap refined = refine_by_pictures(map, pictures_of(stepped, {}), 2);
    for (int y = 10; y < kHeight - 10; ++y) {
        EXPECT_NEAR(refined.at(kStep - 1, y), stepped(kStep - 1, y), 1) << y;
        EXPECT_NEAR(refined.at(kStep, y), stepped(kStep, y), 1) << y;
    }
    EXPECT_NEAR(refined.at(80, 60), stepped(80, 60), 0.5);
}

// A flap 5 px above the surface, some 20 px long, from kStep on; its step is sharp, or the middle of a ramp.
TEST(ByPictures, AShortStepStaysUnlessItIsBlurred) {
    for (const bool is_blurred : {false, true}) {
        const auto flap = [&](int x, int y) {
            const double ramp = is_blurred ? 0.5 * (x - kStep) + (x < kStep ? 1.5 : 3.5) : x < kStep ? 0 : 5;
            const double along = std::clamp((14 - std::abs(y - 80)) / 8.0, 0.0, 1.0);
            const double across = std::clamp(1 - (x - kStep) / 60.0, 0.0, 1.0);
            return bent(x, y) + along * across * std::clamp(ramp, 0.0, 5.0);
        };
        const DisparityMap refined = refine_by_pictures(map_of(flap, 0.05), pictures_of(flap, {}), 2);
        for (int y = 77; y <= 83; ++y) {
            const float step = refined.at(kStep, y) - refined.at(kStep - 1, y);
            EXPECT_EQ(step > 1, !is_blurred) << y << ": " << step;
        }
    }
}

// A flap as above, some 45 or 75 px long; 43 of 50 parts of what rises lie in its step.
TEST(ByPictures, AShortSoftStepGetsASkirtAndALongOneDoesNot) {
    for (const int half_length : {24, 40}) {
        const auto flap = [&](int x, int y) {
            const double along = std::clamp((half_length - std::abs(y - 80)) / 8.0, 0.0, 1.0);
            const double across = std::clamp(1 - (x - kStep) / 60.0, 0.0, 1.0);
            const double share = x < kStep - 1 ? 0 : x < kStep ? 0.07 : x < kStep + 1 ? 0.93 : 1;
            return bent(x, y) + 5 * along * across * share;
        };
        const DisparityMap refined = refine_by_pictures(map_of(flap, 0.05), pictures_of(flap, {}), 2);
        for (int y = 75; y <= 85; ++y) {
            float steepest = 0;
            for (int x = kStep - 10; x < kStep + 5; ++x)
                steepest = std::max(steepest, std::abs(refined.at(x + 1, y) - refined.at(x, y)));
            EXPECT_EQ(steepest < 1.01f, half_length == 24) << y << ": " << steepest;
            EXPECT_NEAR(refined.at(kStep, y), flap(kStep, y), 1) << y;
            EXPECT_NEAR(refined.at(kStep - 8, y), flap(kStep - 8, y), 0.5) << y;
        }
    }
}

TEST(ByPictures, UnknownStaysUnknownForAnyNumberOfThreads) {
    DisparityMap map = map_of(stepped, 0.1);
    for (int x = 30; x < 60; ++x) map.at(x, 40) = kUnknownDisparity;
    for (int x = 90; x < 120; ++x)
        map.origins[static_cast<std::size_t>(90) * kWidth + x] = PixelOrigin::filled;
    const StereoPair pair = pictures_of(stepped, {});
    const DisparityMap one = refine_by_pictures(map, pair, 1), three = refine_by_pictures(map, pair, 3);
    EXPECT_EQ(one.values, three.values);
    for (std::size_t i = 0; i < map.values.size(); ++i)
        EXPECT_EQ(DisparityMap::known(one.values[i]), DisparityMap::known(map.values[i]));
}

TEST(ByPictures, WithoutMatchesNothingChanges) {
    DisparityMap map = map_of(bent, 0.1);
    map.origins.assign(map.values.size(), PixelOrigin::filled);
    EXPECT_EQ(refine_by_pictures(map, pictures_of(bent, {}), 1).values, map.values);
}

}  // namespace
}  // namespace hexrelief::stages
