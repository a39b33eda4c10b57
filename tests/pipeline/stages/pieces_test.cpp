#include "pipeline/stages/other_views/pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "pipeline/stages/surface.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 100, kHeight = 60;
constexpr double kWall = 10, kReach_px = 64;
constexpr std::size_t kLeast = 30;

// Two squares of a wall on both sides of a post that covers columns 20 to 80 in the left and the right view.
struct Scene {
    Calibration camera;
    SurfaceMesh mesh;
    VisibleSurface visible{{}, 1};

    explicit Scene(float behind_px = 0) {
        camera.focal_px = 100;
        camera.baseline_m = 1;
        camera.cx = kWidth / 2.0;
        camera.cy = kHeight / 2.0;
        camera.doffs_px = 0;
        camera.width = kWidth;
        camera.height = kHeight;
        add_square(32, kWall);
        add_square(60, kWall - behind_px);
        for (const double right : {0.0, 1.0}) {
            visible.seen.push_back({{right, 0, 0, 1, kWidth, kHeight}, Disparities(kWidth * kHeight, kWall)});
            for (int y = 0; y < kHeight; ++y)
                std::fill_n(&visible.seen.back().disparities[y * kWidth + 20], 60, 30);
        }
    }
    void add_square(float x, double d) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const Vec2f at : {Vec2f{x, 20}, {x, 30}, {x + 8, 30}, {x + 8, 20}}) {
            const auto [px, py, pz] = position_in_space(at.x, at.y, d, camera);
            mesh.positions.push_back(
                {static_cast<float>(px), static_cast<float>(py), static_cast<float>(pz)});
            mesh.normals.push_back({0, 0, 1});
            mesh.texcoords.push_back({at.x / kWidth, at.y / kHeight});
            mesh.image_points.push_back(at);
            mesh.disparities.push_back(static_cast<float>(d));
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
    }
    void join(const PieceStrips& strips = {kLeast, kReach_px}) { join_pieces(mesh, visible, camera, strips); }
    int pieces() const { return count_topology(mesh).components; }
};

TEST(Pieces, AreJoinedBehindNearerThings) {
    Scene scene;
    ASSERT_EQ(scene.pieces(), 2);
    scene.join();
    EXPECT_EQ(scene.pieces(), 1);
    EXPECT_EQ(count_topology(scene.mesh).boundary_loops, 1);
    ASSERT_EQ(scene.mesh.triangles.size(), 2 + 2 + 6);
    ASSERT_EQ(scene.mesh.positions.size(), 4 + 4 + 4);
    for (std::size_t i = 8; i < 12; ++i) {
        EXPECT_EQ(scene.mesh.disparities[i], static_cast<float>(kWall));
        EXPECT_FLOAT_EQ(scene.mesh.positions[i].z, scene.mesh.positions[0].z);
        const float x = scene.mesh.texcoords[i].x * kWidth;
        EXPECT_TRUE(x == 40 || x == 60) << "the colours of its beginning, not of the post: " << x;
        EXPECT_EQ(scene.mesh.texcoords[i].x, scene.mesh.texcoords[8].x);
    }
}

TEST(Pieces, StayAloneWhereACameraWouldSeeTheStrip) {
    for (std::size_t camera = 0; camera < 2; ++camera)
        for (const double d : {kWall - 2, kNotCovered}) {
            Scene scene;
            // A slit in the post, as this camera sees it where the strip would be.
            for (int y = 0; y < kHeight; ++y)
                std::fill_n(&scene.visible.seen[camera].disparities[y * kWidth + (camera == 0 ? 45 : 35)], 10,
                            d);
            scene.join();
            EXPECT_EQ(scene.pieces(), 2) << camera << ", " << d;
        }
}

TEST(Pieces, StayAloneIfAskedWhereNoViewShowsTheStrip) {
    for (const bool only_in_views : {false, true}) {
        Scene scene;
        for (SeenSurface& seen : scene.visible.seen) {
            seen.place.width = 20;  // in both views the squares are farther right
            seen.disparities.assign(static_cast<std::size_t>(seen.place.width) * kHeight, kWall);
        }
        scene.join({kLeast, kReach_px, only_in_views});
        EXPECT_EQ(scene.pieces(), only_in_views ? 2 : 1);
    }
}

TEST(Pieces, StayAloneIfTheyAreLargeOrFarOrAtAnotherDepth) {
    Scene large, far, deep(4), near(2);
    large.join({2, kReach_px});
    EXPECT_EQ(large.pieces(), 2);
    far.join({kLeast, 18});
    EXPECT_EQ(far.pieces(), 2);
    deep.join();
    EXPECT_EQ(deep.pieces(), 2);
    near.join();
    EXPECT_EQ(near.pieces(), 1);
}

}  // namespace
}  // namespace hexrelief::stages
