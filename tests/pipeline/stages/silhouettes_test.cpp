// Tests that silhouettes are moved to where the image shows them.
#include "pipeline/stages/silhouettes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/stages/surface_quality.h"

namespace hexrelief::stages {
namespace {

constexpr int kWidth = 60, kHeight = 40;

double plane(double x, double y) {
    return 20 + 0.1 * x - 0.05 * y;
}

// Returns a slanted plane; unknown to the left of x = 20 if `half` is set.
DisparityMap slanted(bool half = false) {
    DisparityMap map{kWidth, kHeight, {}};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            map.values.push_back(half && x < 20 ? kUnknownDisparity : float(plane(x + 0.5, y + 0.5)));
    return map;
}

// Returns a grid of squares of 8 px on the plane, from (left, top) on, each cut in two.
DisparityMesh grid(float left, float top, int columns, int rows) {
    DisparityMesh mesh;
    for (int y = 0; y <= rows; ++y)
        for (int x = 0; x <= columns; ++x) {
            mesh.points.push_back({left + 8.f * x, top + 8.f * y});
            mesh.disparities.push_back(float(plane(mesh.points.back().x, mesh.points.back().y)));
        }
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const auto a = std::uint32_t(y * (columns + 1) + x), b = a + 1, c = a + columns + 1, d = c + 1;
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({b, d, c});
        }
    return mesh;
}

SurfaceQuality quality(const DisparityMesh& mesh, const DisparityMap& map) {
    SurfaceMesh surface;
    surface.image_points = mesh.points;
    surface.disparities = mesh.disparities;
    surface.triangles = mesh.triangles;
    return measure_surface_quality(surface, map, 0, 1);
}

double moved(const DisparityMesh& a, const DisparityMesh& b, std::size_t i) {
    return std::hypot(a.points[i].x - b.points[i].x, a.points[i].y - b.points[i].y);
}

TEST(Silhouettes, ReachOutForUncoveredPixels) {
    const DisparityMap map = slanted();
    const DisparityMesh before = grid(1.8f, 2.8f, 6, 4);
    DisparityMesh after = before;
    adjust_silhouettes(after, map, 0, 3);
    EXPECT_GT(quality(after, map).coverage, 1.02 * quality(before, map).coverage);
    EXPECT_LT(quality(after, map).rmse_near_px, quality(before, map).rmse_near_px);
    int at_the_border = 0;
    for (std::size_t i = 0; i < before.points.size(); ++i) {
        EXPECT_LE(moved(before, after, i), 0.75 + 1e-4);
        EXPECT_NEAR(after.disparities[i], plane(after.points[i].x, after.points[i].y), 1e-3)
            << "on its surface";
        at_the_border += moved(before, after, i) > 0;
    }
    EXPECT_GT(at_the_border, 10);
    EXPECT_EQ(moved(before, after, 8), 0) << "inside of the mesh";
    EXPECT_EQ(after.triangles, before.triangles);
}

TEST(Silhouettes, StayWhereNothingIsWrong) {
    const DisparityMap map = slanted(true);
    const DisparityMesh before = grid(19.8f, 0, 5, 5);
    for (const auto& [background_px, rounds] : {std::pair(0.f, 3), {99.f, 3}, {0.f, 0}}) {
        DisparityMesh after = before;
        adjust_silhouettes(after, map, background_px, rounds);
        for (std::size_t i = 0; i < before.points.size(); ++i) EXPECT_EQ(moved(before, after, i), 0) << i;
    }
}

// A near square in front of a far plane, whose border lies a pixel too far out on one side.
TEST(Silhouettes, DrawBackFromTheSurfaceBehind) {
    DisparityMap map{kWidth, kHeight, std::vector<float>(kWidth * kHeight, 8)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < 30; ++x) map.values[y * kWidth + x] = 30;
    DisparityMesh mesh = grid(0, 0, 8, 5);
    for (float& d : mesh.disparities) d = 8;
    const auto count = std::uint32_t(mesh.points.size());
    for (const Vec2f& p : {Vec2f{0, 0}, {30.7f, 0}, {0, 40}, {30.7f, 40}}) {
        mesh.points.push_back(p);
        mesh.disparities.push_back(30);
    }
    mesh.triangles.push_back({count, count + 1, count + 2});
    mesh.triangles.push_back({count + 1, count + 3, count + 2});
    const double before = quality(mesh, map).duo_rmse_near_px;
    adjust_silhouettes(mesh, map, 0, 2);
    EXPECT_LT(mesh.points[count + 1].x, 30.5f);
    EXPECT_LT(mesh.points[count + 3].x, 30.5f);
    EXPECT_LT(quality(mesh, map).duo_rmse_near_px, 0.5 * before);
}

TEST(Silhouettes, NoTriangleTurnsOver) {
    const DisparityMap map = slanted();
    DisparityMesh mesh = grid(4, 3, 6, 4);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        mesh.points[i].x += 2 * float(std::sin(7.0 * i));
        mesh.points[i].y += 2 * float(std::cos(5.0 * i));
    }
    adjust_silhouettes(mesh, map, 0, 4);
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec2f &p = mesh.points[a], &q = mesh.points[b], &r = mesh.points[c];
        EXPECT_GT((q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x), 0);
    }
}

}  // namespace
}  // namespace hexrelief::stages
