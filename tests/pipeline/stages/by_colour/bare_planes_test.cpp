// Tests that bare patches follow planes through their matches, if enough of these lie on one.
#include "pipeline/stages/by_colour/bare_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "pipeline/stages/by_colour/robust_plane.h"

namespace hexrelief::stages {
namespace {

constexpr int kBareWidth = 200, kBareHeight = 150;
constexpr int kLeft = 60, kRight = 160, kTop = 25, kBottom = 125;  // of the bare patch
constexpr float kFilling_px = 30, kBehind_px = 8;

// A bare patch of one level before a matched background of two levels in turn. `surface` is its disparity; it
// is matched where `is_matched` says so, and filled with kFilling_px elsewhere.
struct BareScene {
    DisparityMap map{kBareWidth, kBareHeight, {}, {}};
    StereoPair pair{{kBareWidth, kBareHeight, 1, {}}, {kBareWidth, kBareHeight, 1, {}}};

    template <class Surface, class Matched>
    BareScene(const Surface& surface, const Matched& is_matched) {
        const auto background = [](int x, int y) {
            return static_cast<std::uint8_t>((x + y) % 2 ? 200 : 60);
        };
        pair.right.pixels.resize(static_cast<std::size_t>(kBareWidth) * kBareHeight);
        for (int y = 0; y < kBareHeight; ++y)
            for (int x = 0; x < kBareWidth; ++x)
                *pair.right.at(x, y) = background(x + static_cast<int>(kBehind_px), y);
        for (int y = 0; y < kBareHeight; ++y)
            for (int x = 0; x < kBareWidth; ++x) {
                const bool is_patch = is_on_patch(x, y);
                map.values.push_back(!is_patch ? kBehind_px : is_matched(x, y) ? surface(x, y) : kFilling_px);
                map.origins.push_back(!is_patch || is_matched(x, y) ? PixelOrigin::matched
                                                                    : PixelOrigin::filled);
                pair.left.pixels.push_back(is_patch ? kLevel : background(x, y));
                const int seen = static_cast<int>(std::lround(x - surface(x, y)));
                if (is_patch && seen >= 0) *pair.right.at(seen, y) = kLevel;
            }
    }

    static constexpr std::uint8_t kLevel = 130;
    static bool is_on_patch(int x, int y) { return x >= kLeft && x < kRight && y >= kTop && y < kBottom; }
};

float slanted(int x, int y) {
    return 20 + 0.04f * static_cast<float>(x - kLeft) - 0.03f * static_cast<float>(y - kTop);
}
bool is_at_rim(int x, int y) {
    constexpr int kRim_px = 6;
    return x < kLeft + kRim_px || x >= kRight - kRim_px || y < kTop + kRim_px || y >= kBottom - kRim_px;
}

TEST(BarePlanes, AWallThatMatchedAtItsRimFollowsItsPlane) {
    const BareScene scene(slanted, is_at_rim);
    const DisparityMap result = with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2);
    for (int y = 0; y < kBareHeight; ++y)
        for (int x = 0; x < kBareWidth; ++x) {
            constexpr int kMargin_px = 3;  // squares of both surfaces' colours
            if (!BareScene::is_on_patch(x, y)) {
                EXPECT_EQ(result.at(x, y), kBehind_px) << x << ", " << y;
            } else if (BareScene::is_on_patch(x - kMargin_px, y - kMargin_px) &&
                       BareScene::is_on_patch(x + kMargin_px, y + kMargin_px)) {
                EXPECT_NEAR(result.at(x, y), slanted(x, y), 1) << x << ", " << y;
            }
        }
    EXPECT_EQ(result.origins, scene.map.origins);
    EXPECT_EQ(with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 1).values,
              result.values);
}

TEST(BarePlanes, WrongMatchesOfTwoFifthsOfTheRimDoNotMatter) {
    const auto wrong = [](int x, int y) {
        const bool is_wrong = x >= kRight - 6 || (y < kTop + 6 && x > 95);
        return is_wrong ? 35.0f + 3 * static_cast<float>((x + 5 * y) % 7) : slanted(x, y);
    };
    const BareScene scene(wrong, is_at_rim);
    const DisparityMap result = with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2);
    EXPECT_NEAR(result.at(110, 75), slanted(110, 75), 1);
}

TEST(BarePlanes, ABowlThatMatchedInsideIsNotFlattened) {
    const auto bowl = [](int x, int y) {
        const float u = static_cast<float>(2 * x - kLeft - kRight) / (kRight - kLeft),
                    v = static_cast<float>(2 * y - kTop - kBottom) / (kBottom - kTop);
        return 20 + 12 * (u * u + v * v);
    };
    const auto at_rim_and_specks = [](int x, int y) { return is_at_rim(x, y) || (x % 20 < 6 && y % 20 < 6); };
    const BareScene scene(bowl, at_rim_and_specks);
    EXPECT_EQ(with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2).values,
              scene.map.values);
}

TEST(BarePlanes, APatchWhoseMatchesDisagreeKeepsItsFilling) {
    const auto scattered = [](int x, int y) {
        return slanted(x, y) + static_cast<float>((x / 8 + y / 8) % 3 * 4);
    };
    const BareScene scene(scattered, is_at_rim);
    EXPECT_EQ(with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2).values,
              scene.map.values);
}

TEST(BarePlanes, MatchesInACornerOfAPatchSayNothingAboutTheRest) {
    const auto in_corner = [](int x, int y) { return is_at_rim(x, y) && x < 110 && y < 75; };
    const BareScene scene(slanted, in_corner);
    EXPECT_EQ(with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2).values,
              scene.map.values);
}

TEST(BarePlanes, APlaneThatTheRightPictureContradictsIsRefused) {
    // The matches say 20 px, the right picture shows the patch at kFilling_px.
    const auto is_filled = [](int, int) { return kFilling_px; };
    BareScene scene(is_filled, is_at_rim);
    for (int y = kTop; y < kBottom; ++y)
        for (int x = kLeft; x < kRight; ++x)
            if (is_at_rim(x, y)) scene.map.at(x, y) = 20;
    EXPECT_EQ(with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2).values,
              scene.map.values);
}

TEST(BarePlanes, APlaneGoesOnBeyondTheRightPicturesEdgeIfHalfOfThePatchIsSeen) {
    for (const float nearest_px : {90.0f, 118.0f}) {
        const auto surface = [&](int x, int y) { return slanted(x, y) - 20 + nearest_px; };
        const BareScene scene(
            surface, [&](int x, int y) { return is_at_rim(x, y) && surface(x, y) < static_cast<float>(x); });
        const DisparityMap result =
            with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2);
        if (nearest_px < 100)
            EXPECT_NEAR(result.at(65, 75), surface(65, 75), 1);
        else
            EXPECT_EQ(result.values, scene.map.values);
    }
}

TEST(BarePlanes, MapsWithoutOriginsAndUnknownPixelsStay) {
    BareScene scene(slanted, is_at_rim);
    scene.map.at(100, 70) = kUnknownDisparity;
    scene.map.origins[scene.map.width * 70 + 100] = PixelOrigin::unknown;
    const DisparityMap result = with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2);
    EXPECT_EQ(result.at(100, 70), kUnknownDisparity);
    EXPECT_NEAR(result.at(101, 70), slanted(101, 70), 1);
    scene.map.origins.clear();
    EXPECT_EQ(with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2).values,
              scene.map.values);
}

TEST(BarePlanes, APatchThatMatchedMostlyFollowsItsPlaneInRectifiedPairsOnly) {
    const auto but_in_stripes = [](int x, int) { return x % 3 != 0; };
    const BareScene scene(slanted, but_in_stripes);
    EXPECT_NEAR(with_planes_on_bare_patches(scene.map, scene.pair, Pictures::rectified, 2).at(111, 75),
                slanted(111, 75), 1);
    EXPECT_EQ(with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2).values,
              scene.map.values);
}

// The plane would lie at 5 px at the left end, which did not match.
TEST(BarePlanes, NothingLiesFartherThanAllOfTheMap) {
    const auto rising = [](int x, int) { return 5 + 0.2f * static_cast<float>(x - kLeft); };
    const BareScene scene(rising, [](int x, int y) { return is_at_rim(x, y) && x >= kLeft + 18; });
    const DisparityMap result = with_planes_on_bare_patches(scene.map, scene.pair, Pictures::photographs, 2);
    EXPECT_EQ(result.at(kLeft + 5, 75), kBehind_px);
    EXPECT_NEAR(result.at(kLeft + 40, 75), 13, 1);
}

TEST(BarePlanes, FitIsThatOfTheTrueSamples) {
    std::vector<PlaneSample> samples;
    for (int i = 0; i < 120; ++i) {
        const auto x = static_cast<float>(i * 37 % 101), y = static_cast<float>(i * 53 % 97);
        const float wrong = i % 4 == 0 ? static_cast<float>(5 + i % 7) : 0;
        samples.push_back({x, y, 12 + 0.1f * x - 0.2f * y + wrong, 1.0f / 120});
    }
    const auto fit = fit_plane(samples, 0.5);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->plane.x_slope, 0.1, 1e-4);
    EXPECT_NEAR(fit->plane.y_slope, -0.2, 1e-4);
    EXPECT_NEAR(fit->plane.at(0, 0), 12, 5e-3);
    EXPECT_NEAR(fit->share, 0.75, 1e-5);
    EXPECT_LE(fit->second_share, 0.25);
    EXPECT_FALSE(fit_plane(samples, 0.8));
}

}  // namespace
}  // namespace hexrelief::stages
