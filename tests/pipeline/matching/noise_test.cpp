// Tests the measurement and the reduction of a picture's noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "pipeline/matching/matcher.h"
#include "samples/sample_pair.h"

namespace hexrelief::matching {
namespace {

Image noisy(Image image, double deviation, unsigned seed = 1) {
    std::mt19937 random(seed);
    for (std::uint8_t& level : image.pixels) {
        double sum = -6;  // sum of twelve: nearly normal, and the same with every library
        for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 4294967296.0;
        level = static_cast<std::uint8_t>(std::clamp(std::lround(level + deviation * sum), 0L, 255L));
    }
    return image;
}

Image plain(int width, int height, int channels, std::uint8_t level) {
    return {width, height, channels,
            std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height * channels, level)};
}

TEST(Noise, IsFoundInASmoothAndInATexturedPicture) {
    const Image scene = samples::render_sample_scene().pair.left;
    EXPECT_LT(find_noise(scene), 4);
    for (const double deviation : {5.0, 8.0, 13.0}) {
        EXPECT_NEAR(find_noise(noisy(plain(200, 150, 3, 90), deviation)), deviation, 0.1 * deviation);
        EXPECT_NEAR(find_noise(noisy(scene, deviation)), deviation, 0.25 * deviation);
    }
}

TEST(Noise, IsNotToldByBlackWhiteOrVerySmallPictures) {
    EXPECT_EQ(find_noise(noisy(plain(100, 100, 1, 255), 20)), 0);
    EXPECT_EQ(find_noise(noisy(plain(100, 100, 3, 0), 20)), 0);
    EXPECT_EQ(find_noise(noisy(plain(17, 40, 1, 90), 20)), 0);
    EXPECT_EQ(find_noise(plain(1, 1, 1, 90)), 0);
}

// Denoises pixel by pixel.
Image slowly_denoised(const Image& image, int other_color) {
    constexpr int kNearness[9] = {16, 13, 10, 0, 7, 5, 0, 0, 3};
    Image result = image;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            int weights = 0, sums[3] = {};
            for (int j = -2; j <= 2; ++j)
                for (int i = -2; i <= 2; ++i) {
                    const std::uint8_t* other = image.at(std::clamp(x + i, 0, image.width - 1),
                                                         std::clamp(y + j, 0, image.height - 1));
                    int step = 0;
                    for (int c = 0; c < image.channels; ++c)
                        step = std::max(step, std::abs(other[c] - image.at(x, y)[c]));
                    const int weight = kNearness[i * i + j * j] * std::max(0, other_color - step);
                    weights += weight;
                    for (int c = 0; c < image.channels; ++c) sums[c] += weight * other[c];
                }
            for (int c = 0; c < image.channels; ++c)
                result.at(x, y)[c] = static_cast<std::uint8_t>(
                    static_cast<float>(sums[c]) / static_cast<float>(weights) + 0.5f);
        }
    return result;
}

TEST(Noise, IsAveragedAsPixelByPixel) {
    for (const int channels : {1, 3})
        for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {32, 4}, {67, 19}, {3, 40}}) {
            const Image image = noisy(plain(width, height, channels, 120), 60);
            for (const double noise : {4.0, 7.3, 100.0}) {
                const Image expected =
                    slowly_denoised(image, std::min(160, static_cast<int>(std::lround(5 * noise))));
                for (const int threads : {1, 3}) {
                    Image denoised = image;
                    denoise(denoised, noise, threads);
                    ASSERT_EQ(denoised.pixels, expected.pixels) << width << "x" << height << ", " << noise;
                }
            }
        }
}

TEST(Noise, LittleIsLeftAsItIs) {
    const Image image = noisy(plain(40, 40, 3, 120), 3);
    Image same = image;
    denoise(same, 3.9, 1);
    EXPECT_EQ(same.pixels, image.pixels);
}

TEST(Noise, IsLessAfterwardsAndEdgesStay) {
    Image clean = plain(120, 60, 1, 60);
    for (int y = 0; y < clean.height; ++y)
        std::fill(clean.at(60, y), clean.at(60, y) + 60, std::uint8_t{190});
    Image denoised = noisy(clean, 8);
    denoise(denoised, 8, 1);
    double most = 0;
    for (int x = 0; x < clean.width; ++x) {
        double sum = 0;
        for (int y = 0; y < clean.height; ++y) sum += *denoised.at(x, y);
        most = std::max(most, std::abs(sum / clean.height - *clean.at(x, 0)));
    }
    EXPECT_LT(most, 4);  // beside the edge, too
    EXPECT_LT(find_noise(denoised), 4);
}

}  // namespace
}  // namespace hexrelief::matching
