#include "pipeline/job/relief.h"

#include <gtest/gtest.h>

namespace hexrelief::job {
namespace {

constexpr float kNo = kUnknownDisparity;

TEST(PictureShares, UnknownPixelsThatTheRightCameraCannotSeeAreOccluded) {
    // Row 0: six unknown pixels between 2 and 6 px, the last four are hidden behind what has 6 px.
    // Row 1: two at the left edge, left of the right camera's picture; two before a farther surface, seen.
    DisparityMap map{10, 2, {2,   kNo, kNo, kNo, kNo, kNo, kNo, 6, 6, 6,  //
                             kNo, kNo, 3,   3,   kNo, kNo, 1,   1, 1, 0.5f}};
    SurfaceMesh surface;
    surface.image_points = {{0, 0}, {4, 0}, {0, 2}, {4, 2}};
    surface.triangles = {{0, 2, 1}, {1, 2, 3}};
    const PictureShares shares = share_picture(map, 1, surface, surface.triangles.size());
    EXPECT_DOUBLE_EQ(shares.occluded, 6 / 20.0);
    EXPECT_DOUBLE_EQ(shares.unknown, 4 / 20.0);
    EXPECT_DOUBLE_EQ(shares.background, 1 / 20.0);
    EXPECT_DOUBLE_EQ(shares.foreground, 9 / 20.0);
    EXPECT_DOUBLE_EQ(shares.known(), 10 / 20.0);
    EXPECT_DOUBLE_EQ(shares.meshed, 8 / 20.0);
}

}  // namespace
}  // namespace hexrelief::job
