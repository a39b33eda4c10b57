#include "pipeline/stages/other_views/texture_synthesis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "pipeline/stages/other_views/backing.h"
#include "pipeline/stages/other_views/backing_texture.h"
#include "pipeline/stages/other_views/behind_silhouettes.h"

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 160, kHeight = 120, kThingBegin = 70, kThingEnd = 130, kPeriod = 16;
constexpr double kNear = 60, kWall = 20;
constexpr int kThing = 250;

std::size_t at(int x, int y) {
    return static_cast<std::size_t>(y) * kWidth + x;
}

// Slanted stripes, which rise slowly and fall at once, so that they look otherwise in a mirror.
int stripes(int x, int y) {
    return 40 + 8 * ((x + y / 2) % kPeriod);
}

// A striped wall, of which a near thing of one colour hides a part that continues for `long_px` from the
// left.
struct StripedWall {
    ViewPlace place;
    Disparities front;
    Continued continued{static_cast<std::size_t>(kWidth) * kHeight};
    Image picture{kWidth, kHeight, 1, std::vector<std::uint8_t>(static_cast<std::size_t>(kWidth) * kHeight)};

    explicit StripedWall(int long_px, double wall = kWall)
        : front(static_cast<std::size_t>(kWidth) * kHeight) {
        place.width = kWidth;
        place.height = kHeight;
        std::fill(continued.disparities.begin(), continued.disparities.end(), kNotCovered);
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const bool is_near = x >= kThingBegin && x < kThingEnd;
                front[at(x, y)] = is_near ? kNear : kWall;
                *picture.at(x, y) = static_cast<std::uint8_t>(is_near ? kThing : stripes(x, y));
                if (!is_near || x >= kThingBegin + long_px) continue;
                continued.offer(at(x, y), wall, x - kThingBegin + 1, at(2 * kThingBegin - x - 1, y));
                continued.pixels.push_back(static_cast<std::uint32_t>(at(x, y)));
            }
    }
    Image painted(int threads) {
        ThreadPool pool(threads);
        return with_texture(picture, place, continued, front, pool);
    }
};

TEST(TextureSynthesis, StripesGoOnBehindTheNearThing) {
    StripedWall scene(24);
    const Image painted = scene.painted(2);
    int like_wall = 0, like_mirror = 0, all = 0;
    for (int y = 10; y < kHeight - 10; ++y)
        for (int x = kThingBegin; x < kThingBegin + 24; ++x, ++all) {
            like_wall += std::abs(*painted.at(x, y) - stripes(x, y)) < 20;
            like_mirror += std::abs(*painted.at(x, y) - stripes(2 * kThingBegin - x - 1, y)) < 20;
        }
    EXPECT_GT(like_wall, 9 * all / 10);
    EXPECT_LT(like_mirror, all / 2) << "the stripes cannot tell the two";
    EXPECT_TRUE(scene.continued.pixels.empty()) << "all is painted";
}

TEST(TextureSynthesis, PaintsInAPictureOfAnySize) {
    for (const auto& [width, height] : {std::pair{80, 60}, {320, 240}, {79, 59}}) {
        StripedWall scene(24);
        const auto column = [&](int u) { return (2 * u + 1) * kWidth / (2 * width); };
        const auto row = [&](int v) { return (2 * v + 1) * kHeight / (2 * height); };
        Image picture{width, height, 1, {}};
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u) picture.pixels.push_back(*scene.picture.at(column(u), row(v)));
        scene.picture = picture;
        const Image painted = scene.painted(2);
        double error = 0;
        int all = 0;
        for (int v = 10; v < height - 10; ++v)
            for (int u = 0; u < width; ++u) {
                const int x = column(u);
                if (x <= kThingBegin || x >= kThingBegin + 23) continue;
                error += std::abs(*painted.at(u, v) - stripes(x, row(v)));
                ++all;
            }
        EXPECT_LT(error / all, 16) << width;
    }
}

TEST(TextureSynthesis, GreyPicturesAreLikeThoseOfThreeEqualChannels) {
    StripedWall scene(24), colourful(24);
    colourful.picture = {kWidth, kHeight, 3, {}};
    for (const std::uint8_t level : scene.picture.pixels)
        colourful.picture.pixels.insert(colourful.picture.pixels.end(), 3, level);
    const Image grey = scene.painted(2), painted = colourful.painted(2);
    for (std::size_t i = 0; i < grey.pixels.size(); ++i)
        ASSERT_EQ(grey.pixels[i], painted.pixels[3 * i]) << i;
}

TEST(TextureSynthesis, NothingHasTheColoursOfTheNearThingOrOfMixedPixels) {
    StripedWall scene(20);
    scene.continued.is_mixed.resize(scene.front.size());
    for (int y = 0; y < kHeight; ++y)
        for (int x = kThingBegin - 6; x < kThingBegin; ++x) {
            scene.continued.is_mixed[at(x, y)] = 1;
            *scene.picture.at(x, y) = kThing;
        }
    const Image painted = scene.painted(2);
    for (int y = 0; y < kHeight; ++y)
        for (int x = kThingBegin; x < kThingBegin + 20; ++x)
            EXPECT_LE(*painted.at(x, y), 40 + 8 * kPeriod) << x << ' ' << y;
    EXPECT_EQ(*painted.at(kThingBegin - 3, 60), kThing) << "what the view shows stays";
    EXPECT_EQ(*painted.at(kThingBegin + 30, 60), kThing) << "nothing continues there";
}

TEST(TextureSynthesis, SeamsHaveTheLightOfWhatIsBeside) {
    StripedWall scene(24);
    for (int y = 0; y < kHeight; ++y)  // brighter all around the hidden part than its sources are
        for (int x = 0; x < kThingBegin; ++x)
            *scene.picture.at(x, y) = static_cast<std::uint8_t>(60 + x + (x + y) % 2);
    const Image painted = scene.painted(2);
    int steps = 0;
    for (int y = 10; y < kHeight - 10; ++y)
        steps += std::abs(*painted.at(kThingBegin, y) - *painted.at(kThingBegin - 1, y)) > 8;
    EXPECT_LT(steps, 5);
}

TEST(TextureSynthesis, ALittleFartherOneGivesItsTextureIfNoOtherDoes) {
    StripedWall scene(24, kWall - 19);  // 0.3 of the step would be 17.7
    scene.painted(2);
    EXPECT_TRUE(scene.continued.pixels.empty()) << "all is painted";
}

TEST(TextureSynthesis, AnotherSurfaceIsNotLikeIt) {
    StripedWall scene(24, kWall - 70);
    const std::vector<std::uint32_t> pixels = scene.continued.pixels;
    EXPECT_EQ(scene.painted(2).pixels, scene.picture.pixels);
    EXPECT_EQ(scene.continued.pixels, pixels);
}

TEST(TextureSynthesis, IsTheSameForAnyNumberOfThreads) {
    const std::vector<std::uint8_t> one = StripedWall(40).painted(1).pixels;
    EXPECT_NE(one, StripedWall(40).picture.pixels);
    for (const int threads : {2, 3, 5}) EXPECT_EQ(StripedWall(40).painted(threads).pixels, one);
}

TEST(TextureSynthesis, OfTwoSurfacesTheOneAtItsDepthGoesOn) {
    constexpr int kOther = kThingBegin + 20, kLevel = 100, kOtherLevel = 121;
    StripedWall scene(kOther - kThingBegin);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const bool is_other = x >= kOther;
            if (is_other) scene.front[at(x, y)] = kWall + 11;
            *scene.picture.at(x, y) = is_other ? kOtherLevel : x < kThingBegin ? kLevel : kThing;
        }
    const Image painted = scene.painted(2);
    for (int x = kThingBegin; x < kOther; ++x) EXPECT_NEAR(*painted.at(x, 60), kLevel, 3) << x;
}

TEST(TextureSynthesis, ABackingHasItsOwnTextureBehindAnotherSurfaceThatContinues) {
    constexpr int kOther = kThingBegin + 14, kOtherLevel = 230;
    StripedWall scene(0);
    for (int y = 0; y < kHeight; ++y)
        for (int x = kOther; x < kWidth; ++x) {
            scene.front[at(x, y)] = (kNear + kWall) / 2;
            *scene.picture.at(x, y) = kOtherLevel;
        }
    const SeenSurface here{scene.place, scene.front};
    OtherView view{scene.place, {}, {}, scene.picture};
    view.missing = {kWidth, kHeight, std::vector<float>(scene.front.size(), kUnknownDisparity)};
    OtherView backing = backing_of(here, scene.picture, 1, 1, 1);
    Behind hidden =
        continue_behind(view, here, {1, 1, 0, 0, Beyond::kMixedOfPhotographs_px}, {{here}, kWall - 10}, 2);
    keep_behind_continued(backing, view.missing);
    paint_behind(view, std::move(hidden), &backing, 2);
    const int x = kOther - 4;
    ASSERT_NEAR(view.missing.at(x, 60), (kNear + kWall) / 2, 1);
    EXPECT_NEAR(*view.color.at(x, 60), kOtherLevel, 10);
    EXPECT_EQ(backing.texture().width, kWidth / 2);
    EXPECT_LE(*backing.texture().at(x / 2, 30), 40 + 8 * kPeriod) << "the wall's";
}

TEST(TextureSynthesis, ABackingGoesOnBehindWhatContinues) {
    const StripedWall scene(0);
    const SeenSurface here{scene.place, scene.front};
    OtherView view{scene.place, {}, {}, scene.picture};
    view.missing = {kWidth, kHeight, std::vector<float>(scene.front.size(), kUnknownDisparity)};
    OtherView backing = backing_of(here, scene.picture, 1, 1, 1);
    const VisibleSurface visible{{here}, kWall - 10};
    Behind hidden =
        continue_behind(view, here, {.left = 1, .mixed_px = Beyond::kMixedOfPhotographs_px}, visible, 2);
    keep_behind_continued(backing, view.missing);
    paint_behind(view, std::move(hidden), &backing, 2);
    const Image& painted = backing.texture();
    const int end = kThingBegin + kWidth / 10;
    ASSERT_FALSE(DisparityMap::known(view.missing.at(end - 1, 60))) << "it ends before the backing does";
    ASSERT_TRUE(DisparityMap::known(backing.missing.at(end - 1, 60)));
    for (int x = kThingBegin / 2; x < end / 2; ++x) EXPECT_LE(*painted.at(x, 30), 40 + 8 * kPeriod) << x;
    int rough = 0;
    for (int x = kThingBegin / 2; x + 1 < end / 2; ++x)
        rough += std::abs(*painted.at(x, 30) - *painted.at(x + 1, 30));
    EXPECT_GT(rough, 4 * (end - kThingBegin)) << "the stripes are there";
}

TEST(TextureSynthesis, ABackingIsBehindWhatContinuesAndNoFartherThanAnything) {
    const StripedWall scene(0);
    const SeenSurface here{scene.place, scene.front};
    OtherView view{scene.place, {}, {}, scene.picture};
    view.missing = {kWidth, kHeight, std::vector<float>(scene.front.size(), kUnknownDisparity)};
    constexpr double kLeast = kWall - 0.25;
    OtherView backing = backing_of(here, scene.picture, 1, kLeast, 1);
    for (const float d : backing.missing.values) EXPECT_TRUE(!DisparityMap::known(d) || d >= kLeast) << d;
    Behind hidden = continue_behind(view, here, {.left = 1}, {{here}, kLeast}, 2);
    keep_behind_continued(backing, view.missing);
    paint_behind(view, std::move(hidden), &backing, 2);
    int both = 0;
    for (std::size_t i = 0; i < scene.front.size(); ++i)
        if (DisparityMap::known(view.missing.values[i]) && DisparityMap::known(backing.missing.values[i])) {
            EXPECT_LT(backing.missing.values[i], view.missing.values[i]);
            ++both;
        }
    EXPECT_GT(both, 100);
}

}  // namespace
}  // namespace hexrelief::stages
