#include "pipeline/checks/pair_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

namespace hexrelief::checks {
namespace {

// A picture of 160 x 80 px whose left half has texture and right half has none, and its map of 4 px.
struct Scene {
    Image left{160, 80, 1, std::vector<std::uint8_t>(std::size_t{160} * 80, 128)};
    DisparityMap map{160, 80, std::vector<float>(std::size_t{160} * 80, 4.0f),
                     std::vector<PixelOrigin>(std::size_t{160} * 80, PixelOrigin::matched)};
    Scene() {
        std::mt19937 random(3);
        for (int y = 0; y < 80; ++y)
            for (int x = 0; x < 80; ++x)
                left.pixels[static_cast<std::size_t>(y) * 160 + x] = static_cast<std::uint8_t>(random());
    }
    void fill(int x0, int x1, int y0, int y1) {
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x)
                map.origins[static_cast<std::size_t>(y) * 160 + x] = PixelOrigin::filled;
    }
};

TEST(PairSupport, IsTheAgreedShareOfWhatHasTexture) {
    Scene scene;
    EXPECT_EQ(measure_support(scene.left, scene.map, {}, {}, 2), 1);
    scene.fill(80, 160, 0, 80);
    EXPECT_EQ(measure_support(scene.left, scene.map, {}, {}, 2), 1);
    scene.fill(0, 80, 0, 40);
    EXPECT_NEAR(measure_support(scene.left, scene.map, {}, {}, 2), 0.5, 1e-9);
}

TEST(PairSupport, LeavesOutWhatTheRightPictureCannotShow) {
    Scene scene;
    scene.fill(0, 4, 0, 80);  // left of the right picture's frame
    EXPECT_EQ(measure_support(scene.left, scene.map, {}, {}, 2), 1);
    scene.fill(4, 80, 0, 40);  // outside of what a corrected right view shows
    std::vector<std::uint8_t> seen(std::size_t{160} * 80, 1);
    std::fill_n(seen.begin(), std::size_t{160} * 40, 0);
    EXPECT_EQ(measure_support(scene.left, scene.map, {}, seen, 2), 1);
}

TEST(PairSupport, LeavesOutWhatIsMasked) {
    Scene scene;
    scene.fill(0, 160, 0, 40);
    std::vector<std::uint8_t> kept(std::size_t{160} * 80, 1);
    for (std::size_t i = 0; i < std::size_t{160} * 40; ++i) kept[i] = 0;
    EXPECT_EQ(measure_support(scene.left, scene.map, kept, {}, 2), 1);
}

TEST(PairSupport, WithoutTextureThereIsNone) {
    Scene scene;
    scene.left.pixels.assign(scene.left.pixels.size(), 7);
    EXPECT_EQ(measure_support(scene.left, scene.map, {}, {}, 2), 0);
}

TEST(PairSupport, HasThreeWords) {
    EXPECT_EQ(support_word(0.9), std::string("good"));
    EXPECT_EQ(support_word(0.55), std::string("partly"));
    EXPECT_EQ(support_word(0.2), std::string("hardly"));
    EXPECT_TRUE(is_hardly_supported(0.2));
    EXPECT_FALSE(is_hardly_supported(0.55));
}

}  // namespace
}  // namespace hexrelief::checks
