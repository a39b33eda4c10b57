// Tests that a body is closed, of the right size, and printable.
#include "exporters/formats/solid_body.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "exporters/exporter.h"
#include "exporters/mesh_formats.h"
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

TEST(SolidBody, EveryEdgeHasTwoTrianglesOfOppositeDirections) {
    const SurfaceMesh body = solid_body(surface(), 100);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const Triangle& t : body.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
    for (const auto& [side, count] : sides) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(sides.contains({side.second, side.first}));
    }
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
    ExportConfig config;
    config.solid = SolidKind::base;
    config.solid_size_mm = 50;
    for (const char* name : {"a.stl", "a.3mf"}) {
        export_scene({&mesh, nullptr, "test", ""}, config, folder / name);
        const inspect::MeshDescription file = describe_mesh(folder / name);
        EXPECT_EQ(file.triangles, static_cast<long long>(body.triangles.size())) << name;
        EXPECT_EQ(file.min.z, 0) << name;
        EXPECT_NEAR(std::max(file.max.x - file.min.x, file.max.y - file.min.y), 50, 0.05) << name;
    }
}

}  // namespace
}  // namespace hexrelief::exporters
