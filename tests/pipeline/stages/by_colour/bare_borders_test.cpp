// Tests that bare bands beside nearer things are given back, and that nothing else is.
#include "pipeline/stages/by_colour/bare_borders.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace hexrelief::stages {
namespace {

constexpr int kViewWidth = 400, kViewHeight = 200;
constexpr int kCentreX = 200, kCentreY = 100, kRadius = 50, kGrown = 57;  // the disc as it is, as it matched
constexpr float kDisc_px = 30, kBareWall_px = 5;

int squared(int x) {
    return x * x;
}
bool is_within(int x, int y, int radius) {
    return squared(x - kCentreX) + squared(y - kCentreY) < squared(radius);
}

// A chequered disc in front of a wall with a slight gradient. The disc's disparities have grown over a band
// of the wall.
struct DiscBeforeWall {
    DisparityMap map{kViewWidth, kViewHeight, {}, {}};
    Image left{kViewWidth, kViewHeight, 3, {}};

    // wall(x, y), disc(x, y): levels
    template <typename Wall, typename Disc>
    DiscBeforeWall(const Wall& wall, const Disc& disc) {
        for (int y = 0; y < kViewHeight; ++y)
            for (int x = 0; x < kViewWidth; ++x) {
                map.values.push_back(is_within(x, y, kGrown) ? kDisc_px : kBareWall_px);
                const int level = is_within(x, y, kRadius) ? disc(x, y) : wall(x, y);
                for (int c = 0; c < 3; ++c) left.pixels.push_back(static_cast<std::uint8_t>(level));
            }
    }
    // Returns the share of the band's pixels, apart from those within `margin` of the contour, that are of
    // the wall.
    double given(const DisparityMap& result, int margin) const {
        int of_wall = 0, all = 0;
        for (int y = 0; y < kViewHeight; ++y)
            for (int x = 0; x < kViewWidth; ++x) {
                if (is_within(x, y, kRadius + margin) || !is_within(x, y, kGrown)) continue;
                ++all;
                of_wall += result.at(x, y) == kBareWall_px;
            }
        return static_cast<double>(of_wall) / all;
    }
};

int gradient(int x, int /*y*/) {
    return 120 + x / 20;
}
int chequers(int x, int y) {
    return (x / 4 + y / 4) % 2 > 0 ? 60 : 20;
}

TEST(BareBorders, AreGivenBackUpToTheContour) {
    const DiscBeforeWall scene(gradient, chequers);
    const DisparityMap rectified = with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 2),
                       photographs =
                           with_bare_borders_behind(scene.map, scene.left, Pictures::photographs, 2);
    EXPECT_EQ(scene.given(rectified, 1), 1);
    EXPECT_EQ(scene.given(photographs, 2), 1);
    EXPECT_LT(scene.given(photographs, 0), scene.given(rectified, 0));
    for (int y = 0; y < kViewHeight; ++y)
        for (int x = 0; x < kViewWidth; ++x)
            if (is_within(x, y, kRadius - 1)) {
                EXPECT_EQ(rectified.at(x, y), kDisc_px) << x << ", " << y;
                EXPECT_EQ(photographs.at(x, y), kDisc_px) << x << ", " << y;
            }
}

TEST(BareBorders, OfTheNearerThingsColourStay) {
    const DiscBeforeWall scene(gradient, gradient);
    EXPECT_EQ(with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 2).values,
              scene.map.values);
}

TEST(BareBorders, WithTextureStay) {
    const auto rough = [](int x, int y) { return 150 + 40 * ((x / 4 + y / 4) % 2); };
    const DiscBeforeWall scene(rough, chequers);
    EXPECT_EQ(with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 2).values,
              scene.map.values);
}

TEST(BareBorders, ThingsThatStandAtTheirContourStay) {
    DiscBeforeWall scene(gradient, [](int, int) { return 60; });
    for (int y = 0; y < kViewHeight; ++y)
        for (int x = 0; x < kViewWidth; ++x)
            scene.map.at(x, y) = is_within(x, y, kRadius) ? kDisc_px : kBareWall_px;
    for (const Pictures pictures : {Pictures::rectified, Pictures::photographs})
        EXPECT_EQ(with_bare_borders_behind(scene.map, scene.left, pictures, 2).values, scene.map.values);
}

// A leak of the contour keeps what is beside it, not the rest of the band.
TEST(BareBorders, AreGivenBackBesideALeak) {
    const auto leaky = [](int x, int y) {
        return x > kCentreX && y > kCentreY - 6 && y < kCentreY + 6 ? gradient(x, y) : chequers(x, y);
    };
    const DiscBeforeWall scene(gradient, leaky);
    const DisparityMap result = with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 2);
    EXPECT_EQ(result.at(kCentreX - kRadius - 3, kCentreY), kBareWall_px);
    EXPECT_EQ(result.at(kCentreX + 10, kCentreY), kDisc_px);
}

// A band beside one that is given itself goes to what that one goes to.
TEST(BareBorders, GoToTheFarthestOfThreeSurfaces) {
    DiscBeforeWall scene(gradient, chequers);
    constexpr int kRing_px = 5;
    for (int y = 0; y < kViewHeight; ++y)
        for (int x = 0; x < kViewWidth; ++x)
            if (is_within(x, y, kGrown + kRing_px) && !is_within(x, y, kGrown)) scene.map.at(x, y) = 15;
    const DisparityMap result = with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 2);
    EXPECT_EQ(scene.given(result, 1), 1);
    for (const float d : result.values) EXPECT_NE(d, 15);
}

TEST(BareBorders, MapsOfAPixelStay) {
    const DisparityMap pixel{1, 1, {kDisc_px}, {}};
    const Image left{1, 1, 3, {10, 20, 30}};
    EXPECT_EQ(with_bare_borders_behind(pixel, left, Pictures::photographs, 2).values, pixel.values);
}

TEST(BareBorders, AnyNumberOfThreads) {
    const DiscBeforeWall scene(gradient, chequers);
    EXPECT_EQ(with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 1).values,
              with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 7).values);
}

// What lies farther from the step than a 40th of the longer side is followed in photographs' far end alone.
TEST(BareBorders, OfAPhotographsFarEndAreFollowedFarther) {
    DiscBeforeWall scene(gradient, chequers);
    for (int y = 0; y < kViewHeight; ++y)
        for (int x = 0; x < kViewWidth; ++x)
            if (is_within(x, y, kRadius + 30)) scene.map.at(x, y) = kDisc_px;
    EXPECT_EQ(with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 2).values,
              scene.map.values);
    EXPECT_EQ(scene.given(with_bare_borders_behind(scene.map, scene.left, Pictures::photographs, 2), 2), 1);
}

TEST(BareBorders, UnknownPixelsAndGreyPictures) {
    DiscBeforeWall scene(gradient, chequers);
    Image grey{kViewWidth, kViewHeight, 1, {}};
    for (std::size_t i = 0; i < scene.left.pixels.size(); i += 3) grey.pixels.push_back(scene.left.pixels[i]);
    const float unknown = scene.map.at(kCentreX, kCentreY - kGrown + 3) = kUnknownDisparity;
    const DisparityMap result = with_bare_borders_behind(scene.map, scene.left, Pictures::rectified, 2);
    EXPECT_EQ(result.at(kCentreX, kCentreY - kGrown + 3), unknown);
    EXPECT_EQ(with_bare_borders_behind(scene.map, grey, Pictures::rectified, 2).values, result.values);
    EXPECT_EQ(with_bare_borders_behind(scene.map, {}, Pictures::rectified, 2).values, scene.map.values);
}

}  // namespace
}  // namespace hexrelief::stages
