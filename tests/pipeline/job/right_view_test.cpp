// The right view's map by the surface, on a made-up scene: a box of 20 px of disparity before a wall of 4 px.
#include <gtest/gtest.h>

#include "pipeline/job/right_view.h"

namespace hexrelief::job {
namespace {

class RightView : public testing::Test {
  protected:
    static constexpr int kWidth = 120, kHeight = 60, kThreads = 2;
    static constexpr float kBox = 20, kWall = 4;
    static constexpr int kBoxBegin = 51, kBoxEnd = 81;  // columns of the left view

    DisparityMap map{kWidth, kHeight, std::vector<float>(kWidth* kHeight, kWall)};
    DensityMap density{kWidth, kHeight, std::vector<float>(kWidth* kHeight, 1)};
    Image color{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth* kHeight, 90)};
    Calibration camera{.focal_px = 100, .baseline_m = 1};
    SurfaceMesh mesh;
    stages::OtherView right{{1, 0, 0, 1, kWidth, kHeight}, {}, {}, color};

    RightView() {
        for (int y = 0; y < kHeight; ++y)
            for (int x = kBoxBegin; x < kBoxEnd; ++x) {
                map.at(x, y) = kBox;
                *color.at(x, y) = 200;
                *right.color.at(x - 20, y) = 200;
            }
        add(kBoxBegin, kBoxEnd, kBox);
    }
    // The map is filled at a third of its size: pixels beside the box may be the box's.
    static bool is_beside_box(int x) { return x >= kBoxEnd - 20 && x < kBoxEnd - 17; }
    void add(float x, float end, float disparity) {
        const auto first = static_cast<std::uint32_t>(mesh.image_points.size());
        for (const Vec2f& p : {Vec2f{x, 0}, {end, 0}, {x, kHeight}, {end, kHeight}}) {
            mesh.image_points.push_back(p);
            mesh.disparities.push_back(disparity);
        }
        mesh.triangles.push_back({first, first + 2, first + 1});
        mesh.triangles.push_back({first + 1, first + 2, first + 3});
    }
    DisparityMap map_of_right() const {
        const LeftView left{map, map, density, color, color, camera, camera};
        return map_by_surface(right, stages::see(mesh, right.place, kThreads), left, kThreads);
    }
};

TEST_F(RightView, WhatIsHiddenFromTheLeftCameraLiesOnTheSurfaceOfItsColours) {
    add(0, kBoxBegin, kWall);
    add(kBoxEnd, kWidth, kWall);
    const DisparityMap seen = map_of_right();
    for (int x = 0; x < kWidth; ++x) {
        const bool is_box = x >= kBoxBegin - 20 && x < kBoxEnd - 20;
        if (is_beside_box(x)) continue;
        EXPECT_NEAR(seen.at(x, 30), is_box ? kBox : kWall, 0.1) << x;
    }
}

TEST_F(RightView, BackgroundStaysBackground) {
    // Only the box is meshed.
    density.background_px = 10;
    const DisparityMap seen = map_of_right();
    for (int x = 0; x < kWidth; ++x) {
        const bool is_box = x >= kBoxBegin - 20 && x < kBoxEnd - 20;
        if (is_beside_box(x)) continue;
        EXPECT_EQ(seen.at(x, 30) < density.background_px, !is_box) << x;
    }
}

TEST_F(RightView, NothingSeenIsNothingKnown) {
    mesh = {};
    for (const float d : map_of_right().values) EXPECT_EQ(d, kUnknownDisparity);
}

}  // namespace
}  // namespace hexrelief::job
