#include "pipeline/stages/dequantize/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/stages/dequantize/dequantize.h"

namespace hexrelief::stages {
namespace {

// A matched map of two slanted surfaces with a bend and a step, in sixteenths of a pixel.
DisparityMap matched(double noise_px, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    DisparityMap map{200, 150, {}};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const double surface = (x < 90 ? 30 + 0.05 * x : 12) + 0.03 * y + 0.0004 * (y - 70) * (y - 70);
            map.values.push_back(
                static_cast<float>(std::nearbyint(16 * (surface + noise_px * normal(random))) / 16));
        }
    map.origins.assign(map.values.size(), PixelOrigin::matched);
    return map;
}

double rmse_px(const DisparityMap& map, const DisparityMap& truth) {
    double sum = 0;
    int count = 0;
    for (int y = 8; y < map.height - 8; ++y)
        for (int x = 8; x < map.width - 8; ++x) {
            if (std::abs(x - 90) < 8) continue;
            sum += std::pow(map.at(x, y) - truth.at(x, y), 2);
            ++count;
        }
    return std::sqrt(sum / count);
}

TEST(Noise, IsThatOfTheMatches) {
    for (const double noise_px : {0.08, 0.12, 0.25})
        EXPECT_NEAR(find_noise_px(matched(noise_px, 3), 2), noise_px, 0.15 * noise_px);
}

TEST(Noise, OfSurfacesWithoutAnyIsBelowWhatIsSmoothed) {
    EXPECT_LT(find_noise_px(matched(0, 1), 2), kLeastNoise_px);
    EXPECT_LT(find_noise_px(matched(0.04, 1), 2), kLeastNoise_px);
}

TEST(Noise, FilledPixelsDoNotCount) {
    DisparityMap map = matched(0.2, 5);
    for (std::size_t i = 0; i < map.values.size() / 2; ++i) {
        map.values[i] = 20;
        map.origins[i] = PixelOrigin::filled;
    }
    EXPECT_NEAR(find_noise_px(map, 2), 0.2, 0.03);
    map.origins.assign(map.values.size(), PixelOrigin::filled);
    EXPECT_EQ(find_noise_px(map, 2), 0);
}

TEST(Noise, IsSmoothedAndTheStepStays) {
    const DisparityMap truth = matched(0, 1), noisy = matched(0.12, 1);
    const DisparityMap smooth = dequantize(noisy, smoothing_for(find_noise_px(noisy, 2)).quantum_px, 2);
    EXPECT_LT(rmse_px(smooth, truth), 0.5 * rmse_px(noisy, truth));
    for (int y = 0; y < truth.height; ++y) {
        EXPECT_GT(smooth.at(89, y) - smooth.at(90, y), 20);
        EXPECT_NEAR(smooth.at(89, y), truth.at(89, y), 0.7);
    }
}

TEST(Noise, BelowTheLeastIsLeft) {
    EXPECT_EQ(smoothing_for(0.05).noise_px, 0);
    EXPECT_EQ(smoothing_for(0.02, kLeastNoiseOfRelief_px).noise_px, 0);
    EXPECT_EQ(smoothing_for(0.05, kLeastNoiseOfRelief_px).noise_px, 0.05);
}

}  // namespace
}  // namespace hexrelief::stages
