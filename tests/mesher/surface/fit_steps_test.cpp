// Tests the steps of surface/fit against their headers' contracts, computed in another way.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mesher/surface/fit/fit_disparities_step.h"
#include "mesher/surface/fit/fit_silhouettes_step.h"
#include "mesher/surface/fit/inset_silhouettes_step.h"
#include "mesher/surface/topology/triangle_shape_step.h"

namespace hexrelief::surface {
namespace {

TEST(PlaneFit, FindsThePlaneOfItsPixels) {
    step::Moments m;
    for (int y = 100; y < 106; ++y)
        for (int x = 200; x < 207; ++x) step::add_pixel(m, x, y, static_cast<float>(0.25 * x - 0.5 * y + 60));
    ASSERT_TRUE(step::holds_plane(m));
    EXPECT_NEAR(step::plane_at(m, 203, 102), 0.25 * 202.5 - 0.5 * 101.5 + 60, 1e-6);
}

// Whichever of the corners that may move do move, the triangle is not thinner than allowed, or than it was.
TEST(TriangleShape, CornersThatMayMoveLeaveNoThinTriangle) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> at(0, 10), way(-3, 3);
    int all_free = 0, some_held = 0;
    for (int i = 0; i < 20000; ++i) {
        Vec2f from[3], to[3];
        for (int k = 0; k < 3; ++k) {
            from[k] = {at(random), at(random)};
            to[k] = {from[k].x + way(random), from[k].y + way(random)};
        }
        const step::TriangleSize before = step::triangle_size(from[0], from[1], from[2]);
        if (!(before.area2 > 0)) continue;
        const unsigned free = step::free_corners(from, to, 0.2);
        ++(free == 7 ? all_free : some_held);
        for (unsigned gone = 1; gone < 8; ++gone) {
            if ((gone & free) != gone) continue;
            const auto p = [&](unsigned k) { return gone >> k & 1u ? to[k] : from[k]; };
            const step::TriangleSize size = step::triangle_size(p(0), p(1), p(2));
            EXPECT_FALSE(step::is_thin(size, 0.2) && step::is_thinner(size, before));
        }
    }
    EXPECT_GT(all_free, 1000);
    EXPECT_GT(some_held, 1000);
}

TEST(TriangleShape, CornersWithinTheSlackLeaveNoThinTriangle) {
    std::mt19937 random(12);
    std::uniform_real_distribution<float> at(0, 10), angle(0, 6.2831853f);
    for (int i = 0; i < 20000; ++i) {
        Vec2f p[3];
        for (Vec2f& q : p) q = {at(random), at(random)};
        const float slack = std::sqrt(step::corner_slack2(p[0], p[1], p[2], 0.2));
        for (Vec2f& q : p) {
            const float phi = angle(random);
            q = {q.x + slack * std::cos(phi), q.y + slack * std::sin(phi)};
        }
        EXPECT_TRUE(slack == 0 || !step::is_thin(step::triangle_size(p[0], p[1], p[2]), 0.2 - 1e-5));
    }
}

TEST(SilhouetteFit, AnEdgeIsDrawnToTheCracksThatFaceAsItDoes) {
    // The near surface is on the edge's left; the crack edges lie 0.3 px to the left of it.
    const step::SilhouetteEdgeFrame edge = step::silhouette_edge_frame({0, 5}, {8, 5});
    step::SilhouetteResiduals sums{};
    for (int x = 0; x < 8; ++x) {
        const float mx = static_cast<float>(x) + 0.5f;
        step::add_residual(sums, step::silhouette_residual(edge, {mx, 5.3f, 0, 1}), 1);
        // belongs to another silhouette
        step::add_residual(sums, step::silhouette_residual(edge, {mx, 4.0f, 0, -1}), 1);
        // beyond reach
        step::add_residual(sums, step::silhouette_residual(edge, {mx, 8.0f, 0, 1}), 1);
    }
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(sums.residuals[k] / sums.weights[k], 0.3, 1e-5);
    step::SilhouetteEquation e;
    step::add_edge(e, edge.nx, edge.ny, sums.weights[0], sums.residuals[0]);
    const Vec2f to = step::silhouette_target(e, {4, 5}, 100, 100);
    EXPECT_EQ(to.x, 4);
    EXPECT_GT(to.y, 5.2f);
    EXPECT_LT(to.y, 5.3f) << "and to where it is";
    step::SilhouetteEquation near;
    step::add_edge(near, 0, 1, 1, 0.02);
    EXPECT_EQ(step::silhouette_target(near, {4, 5}, 100, 100), (Vec2f{4, 5})) << "not worth the move";
}

TEST(Inset, MovesInwardsAndAlongTheBorderOnly) {
    const Vec2f corners[3] = {{10, 10}, {20, 10}, {10, 20}};
    step::Inwards inwards;
    step::add_inwards(inwards, corners, 0);
    const Vec2f to = step::inset_point({10, 10}, inwards, 0.5, 100, 100);
    const double to_1024th = 0.5 / 1024 + 1e-6;
    EXPECT_NEAR(to.x, 10 + 0.5 / std::sqrt(2.0), to_1024th);
    EXPECT_NEAR(to.y, 10 + 0.5 / std::sqrt(2.0), to_1024th);
    EXPECT_EQ(step::inset_point({0, 10}, inwards, 0.5, 100, 100).x, 0);
}

}  // namespace
}  // namespace hexrelief::surface
