#include "pipeline/stages/other_views/beyond_left.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 100, kHeight = 200;
constexpr int kFirst = 10, kEnd = 80;  // columns of the surface

// The right view, of whose columns the surface covers some of all rows.
struct Scene {
    OtherView right{{.right = 1, .width = kWidth, .height = kHeight}, {}};
    SeenSurface here;

    template <class DisparityOf>
    explicit Scene(const DisparityOf& disparity_of) {
        const std::size_t size = kWidth * kHeight;
        right.missing = {kWidth, kHeight, std::vector<float>(size, kUnknownDisparity)};
        here = {right.place, Disparities(size, kNotCovered)};
        for (int y = 0; y < kHeight; ++y)
            for (int x = kFirst; x < kEnd; ++x) seen(x, y) = disparity_of(y);
    }
    double& seen(int x, int y) { return here.disparities[static_cast<std::size_t>(y) * kWidth + x]; }
    float missing(int x, int y) const { return right.missing.at(x, y); }
};

double floor_at(int y) {
    return 10 + 0.25 * y;
}

TEST(BeyondLeft, AFloorGoesOnAtBothEndsOfItsRowsUpToThePicturesFrame) {
    Scene scene(floor_at);
    scene.right.kept.assign(kWidth * kHeight, 1);
    for (int y = 0; y < kHeight; ++y) scene.right.kept[y * kWidth + kWidth - 1] = 0;
    continue_beyond_left(scene.right, scene.here);
    for (const int y : {0, 20, kHeight - 1})
        for (const int x : {0, kFirst - 1, kEnd, kWidth - 2})
            EXPECT_NEAR(scene.missing(x, y), floor_at(y), 1e-4) << x << ", " << y;
    EXPECT_EQ(scene.missing(kFirst, 20), kUnknownDisparity);
    EXPECT_EQ(scene.missing(kEnd - 1, 20), kUnknownDisparity);
    EXPECT_EQ(scene.missing(kWidth - 1, 20), kUnknownDisparity);
}

TEST(BeyondLeft, StepsBecomeSmootherFartherOut) {
    Scene scene([](int y) { return y < kHeight / 2 ? 10.0 : 30.0; });
    continue_beyond_left(scene.right, scene.here);
    const auto step_at = [&](int x) {
        float most = 0;
        for (int y = 1; y < kHeight; ++y)
            most = std::max(most, std::abs(scene.missing(x, y) - scene.missing(x, y - 1)));
        return most;
    };
    EXPECT_LT(step_at(kEnd), 20);
    EXPECT_LT(step_at(kWidth - 1), step_at(kEnd) / 2);
}

TEST(BeyondLeft, WhatIsMissingInsideStaysAndGoesOn) {
    Scene scene([](int) { return 30.0; });
    for (int y = 0; y < kHeight; ++y) scene.right.missing.at(kEnd, y) = 10;  // beside a near thing
    continue_beyond_left(scene.right, scene.here);
    EXPECT_EQ(scene.missing(kEnd, 50), 10);
    EXPECT_EQ(scene.missing(kWidth - 1, 50), 10);
}

TEST(BeyondLeft, StripsAboveAndBelowTheSurfaceStayOpen) {
    Scene scene(floor_at);
    // The left view's frame is turned: its last rows show less and less.
    constexpr int kStrip = 5;
    for (int y = kHeight - kStrip; y < kHeight; ++y)
        for (int x = 40; x < kEnd; ++x) scene.seen(x, y) = kNotCovered;
    continue_beyond_left(scene.right, scene.here);
    EXPECT_EQ(scene.missing(70, kHeight - 2), kUnknownDisparity);
    EXPECT_TRUE(DisparityMap::known(scene.missing(kWidth - 1, kHeight - kStrip - 1)));
    // Below a single row that reaches farther, the floor goes on.
    Scene ragged(floor_at);
    for (int x = kEnd; x < kEnd + 10; ++x) ragged.seen(x, 100) = floor_at(100);
    continue_beyond_left(ragged.right, ragged.here);
    EXPECT_NEAR(ragged.missing(kEnd + 9, 101), floor_at(101), 0.2);
}

TEST(BeyondLeft, TeethThatStickOutOfThePictureAreDropped) {
    OtherView right;
    right.place = {1, 0, 0, 1, 20, 20};
    right.kept.assign(400, 1);
    std::fill_n(right.kept.begin(), 20 * 10, std::uint8_t{0});  // the upper half
    DisparityMesh mesh{{{2, 12}, {8, 12}, {5, 5}, {5, 19}}, std::vector<float>(4, 3), {{0, 1, 2}, {0, 3, 1}}};
    drop_not_shown(mesh, right);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 3, 1}}));
}

}  // namespace
}  // namespace hexrelief::stages
