// Tests that a body is closed, of the right size, and printable.
#include "exporters/formats/solid_body.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "exporters/exporter.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

// A surface in two pieces: the sample without the triangles of some of its columns.
SurfaceMesh surface() {
    SurfaceMesh mesh = sample_mesh(9, 7);
    std::erase_if(mesh.triangles, [&](const Triangle& t) {
        const float x = (mesh.texcoords[t[0]].x + mesh.texcoords[t[1]].x + mesh.texcoords[t[2]].x) / 3;
        return x > 0.4f && x < 0.5f;
    });
    return mesh;
}

double volume_of(const SurfaceMesh& mesh) {
    double volume = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3f &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        volume +=
            (a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x)) /
            6.0;
    }
    return volume;
}

void move_to_depth(SurfaceMesh& mesh, std::size_t vertex, float depth) {
    Vec3f& p = mesh.positions[vertex];
    p = {p.x / -p.z * depth, p.y / -p.z * depth, -depth};
}

// The sample at a depth of 2, whose right part is cut off from row `first` on and lies at 3. At its ends the
// cut has no second vertex, as in a surface whose step begins inside it.
SurfaceMesh surface_with_step(int columns, int rows, int cut, int first, int last) {
    SurfaceMesh mesh = sample_mesh(columns, rows);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) move_to_depth(mesh, i, 2);
    for (int row = first; row <= last; ++row) {
        const auto near = static_cast<std::uint32_t>(row * columns + cut);
        const auto far = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(mesh.positions[near]);
        mesh.image_points.push_back(mesh.image_points[near]);
        mesh.texcoords.push_back(mesh.texcoords[near]);
        move_to_depth(mesh, far, 3);
        for (Triangle& t : mesh.triangles)
            if (std::ranges::any_of(t, [&](std::uint32_t i) {
                    return i < far && mesh.image_points[i].x > mesh.image_points[near].x;
                }))
                std::ranges::replace(t, near, far);
    }
    return mesh;
}

// Expects that every side has one of the other direction; returns V - E + F, 2 of one body without tunnels.
long long expect_closed(const SurfaceMesh& body) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const Triangle& t : body.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
    for (const auto& [side, count] : sides) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(sides.contains({side.second, side.first}));
    }
    const auto triangles = static_cast<long long>(body.triangles.size());
    return static_cast<long long>(body.positions.size()) - triangles * 3 / 2 + triangles;
}

TEST(SolidBody, EveryEdgeHasTwoTrianglesOfOppositeDirections) {
    EXPECT_EQ(expect_closed(solid_body(surface(), 100)), 4) << "two bodies";
}

TEST(SolidBody, SilhouettesAreWallsBetweenBothSurfaces) {
    // From border to border, within the surface, and one that ends at the border.
    for (const auto& [first, last] : {std::pair{0, 6}, {2, 4}, {3, 6}}) {
        const SurfaceMesh mesh = surface_with_step(9, 7, 4, first, last), body = solid_body(mesh, 100);
        EXPECT_EQ(expect_closed(body), 2) << first << " to " << last;
        // Each ray has one vertex of the base: none is in the wall's way.
        EXPECT_EQ(body.positions.size(), mesh.positions.size() + 9 * 7);
    }
    // The lid's and the base's triangles, two a side of the border, and one or two a side of the silhouette.
    const SurfaceMesh mesh = surface_with_step(9, 7, 4, 2, 4), body = solid_body(mesh, 100);
    EXPECT_EQ(body.triangles.size(), 2 * mesh.triangles.size() + 2 * 2 * (8 + 6) + 2 * 2 + 2 * 1);
}

// Four squares around a point, near and far by turns: four walls meet on the point's ray.
TEST(SolidBody, WallsThatTouchHaveEdgesOfTheirOwn) {
    SurfaceMesh mesh;
    for (const int row : {0, 1})
        for (const int column : {0, 1}) {
            const auto at = static_cast<std::uint32_t>(mesh.positions.size());
            const float depth = row == column ? 2.0f : 3.0f;
            for (const int y : {row, row + 1})
                for (const int x : {column, column + 1}) {
                    mesh.image_points.push_back({static_cast<float>(x), static_cast<float>(y)});
                    mesh.positions.push_back({(x - 1) * depth, (1 - y) * depth, -depth});
                }
            mesh.triangles.push_back({at, at + 2, at + 1});
            mesh.triangles.push_back({at + 1, at + 2, at + 3});
        }
    const SurfaceMesh body = solid_body(mesh, 100);
    EXPECT_EQ(expect_closed(body), 1) << "two bodies that share a vertex, and a tunnel";
    EXPECT_GT(volume_of(body), 0);
}

TEST(SolidBody, AShellIsClosedAndThinner) {
    const SurfaceMesh mesh = surface_with_step(9, 7, 4, 2, 4),
                      shell = solid_body(mesh, 100, SolidKind::shell);
    EXPECT_EQ(expect_closed(shell), 2);
    EXPECT_GT(volume_of(shell), 0);
    EXPECT_LT(volume_of(shell), 0.7 * volume_of(solid_body(mesh, 100)));
    const auto below = [](const Vec3f& a, const Vec3f& b) { return a.z < b.z; };
    EXPECT_NEAR(std::ranges::min_element(shell.positions, below)->z, 0, 1e-4);
}

// Its farthest point is a corner, on which it could not be printed.
TEST(SolidBody, AShellOfASlantedPlaneStandsOnAFoot) {
    SurfaceMesh mesh = sample_mesh(40, 30);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        move_to_depth(mesh, i, 2 + mesh.texcoords[i].x + mesh.texcoords[i].y);
    const SurfaceMesh shell = solid_body(mesh, 100, SolidKind::shell);
    EXPECT_EQ(expect_closed(shell), 2);
    double foot_mm2 = 0;
    for (const Triangle& t : shell.triangles) {
        const Vec3f &a = shell.positions[t[0]], &b = shell.positions[t[1]], &c = shell.positions[t[2]];
        if (std::max({a.z, b.z, c.z}) > 1e-4) continue;
        foot_mm2 += std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / 2.0;
    }
    EXPECT_GT(foot_mm2, 20);
}

TEST(SolidBody, HolesAreBridgedAndCrumbsGo) {
    SurfaceMesh holed = surface_with_step(40, 30, 20, 5, 25);
    const std::size_t all = holed.triangles.size();
    const auto remove_around = [&](float x, float y) {
        std::erase_if(holed.triangles, [&](const Triangle& t) {
            return std::ranges::any_of(t, [&](std::uint32_t i) {
                return std::hypot(holed.image_points[i].x - x, holed.image_points[i].y - y) < 1;
            });
        });
    };
    remove_around(holed.image_points[10 * 40 + 10].x, holed.image_points[10 * 40 + 10].y);
    remove_around(holed.image_points[12 * 40 + 20].x,
                  holed.image_points[12 * 40 + 20].y);  // on the silhouette
    ASSERT_LT(holed.triangles.size(), all - 10);
    EXPECT_EQ(expect_closed(solid_body(holed, 100)), 2);
    // A triangle of its own, far away.
    const auto at = static_cast<std::uint32_t>(holed.positions.size());
    for (const Vec2f& point : {Vec2f{100, 100}, {100, 101}, {101, 100}}) {
        holed.positions.push_back({0, 0, -2});
        holed.image_points.push_back(point);
    }
    holed.triangles.push_back({at, at + 1, at + 2});
    EXPECT_EQ(expect_closed(solid_body(holed, 100)), 2);
}

TEST(SolidBody, StandsOnABaseOfItsSize) {
    for (const double size : {20.0, 100.0}) {
        const SurfaceMesh body = solid_body(surface(), size);
        EXPECT_GT(volume_of(body), 0);
        Vec3f low = body.positions[0], high = low;
        float least_top = HUGE_VALF;
        const std::size_t count = body.positions.size() / 2;
        for (std::size_t i = 0; i < body.positions.size(); ++i) {
            const Vec3f& p = body.positions[i];
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
            if (i < count) least_top = std::min(least_top, p.z);
        }
        EXPECT_EQ(low.z, 0);
        EXPECT_NEAR(std::max(high.x - low.x, high.y - low.y), size, 1e-3 * size);
        EXPECT_NEAR(least_top, std::min(kLeastThickness_mm, size / 20), 1e-3);
    }
}

// From the camera, at (0, 0) above the base, the body looks as the surface does.
TEST(SolidBody, KeepsTheRaysOfTheCamera) {
    const SurfaceMesh mesh = surface(), body = solid_body(mesh, 100);
    const std::size_t count = mesh.positions.size();
    // The camera's height follows from any vertex and its point on the base.
    const Vec3f top = body.positions[0], base = body.positions[count];
    const double height = top.z * base.x / (base.x - top.x);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3f &p = mesh.positions[i], &q = body.positions[i];
        EXPECT_NEAR(q.x / (height - q.z), p.x / -p.z, 1e-4);
        EXPECT_NEAR(q.y / (height - q.z), p.y / -p.z, 1e-4);
    }
}

TEST(SolidBody, OneFarVertexDoesNotFlattenTheOthers) {
    SurfaceMesh mesh = sample_mesh(60, 50);
    const SurfaceMesh before = solid_body(mesh, 100);
    for (float* k : {&mesh.positions[40].x, &mesh.positions[40].y, &mesh.positions[40].z}) *k *= 1000;
    const SurfaceMesh after = solid_body(mesh, 100);
    EXPECT_NEAR(after.positions[900].z, before.positions[900].z, 0.5);
}

TEST(SolidBody, IsWhatFilesForPrintersHold) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = surface(), body = solid_body(mesh, 50);
    ExportConfig config{.solid = SolidKind::base, .solid_size_mm = 50};
    const Image texture = sample_texture(64, 48);
    for (const char* name : {"a.stl", "a.3mf", "a.glb"}) {
        export_scene({&mesh, &texture, "test", ""}, config, folder / name);
        const bool is_in_metres = name[2] == 'g';
        const double mm = is_in_metres ? 1000 : 1;
        const inspect::MeshDescription file = describe_mesh(folder / name);
        EXPECT_EQ(file.triangles, static_cast<long long>(body.triangles.size())) << name;
        EXPECT_EQ(file.min.z, 0) << name;
        EXPECT_NEAR(mm * std::max(file.max.x - file.min.x, file.max.y - file.min.y), 50, 0.05) << name;
        EXPECT_EQ(file.texture_bytes > 0, name[2] != 's') << name;
        EXPECT_EQ(contents(folder / name).find("EXT_mesh_manifold") != std::string::npos, is_in_metres);
    }
}

}  // namespace
}  // namespace hexrelief::exporters
