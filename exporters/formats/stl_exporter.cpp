// Binary STL, for printing and CAD: only triangles, in export.stl_unit, or a body in mm.
#include <cmath>
#include <cstring>
#include <string>

#include "exporters/core/mesh_format.h"
#include "exporters/inspect/describe_formats.h"

namespace hexrelief::exporters {
namespace {

constexpr std::size_t kStlHeader = 80, kStlTriangle = 50;

Vec3f face_normal(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const Vec3f u = {b.x - a.x, b.y - a.y, b.z - a.z}, v = {c.x - a.x, c.y - a.y, c.z - a.z};
    const Vec3f n = {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    const float length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    if (!(length > 0)) return {0, 0, 0};  // which tells readers to compute it
    return {n.x / length, n.y / length, n.z / length};
}

void write_stl(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    const SurfaceMesh& mesh = *scene.mesh;
    check_32_bits(path, mesh.triangles.size(), "an STL holds at most 4,294,967,295 triangles; write .ply");
    const float scale = !scene.is_body && config.stl_unit == StlUnit::millimetre ? 1000.f : 1.f;
    const UpAxis up = scene.is_body ? UpAxis::y : config.up;
    // The header must not begin with "solid", which would mark the file as text.
    std::string bytes = "binary STL, " + scene.generator + ", " + axes_text(up);
    bytes.resize(kStlHeader + 4 + kStlTriangle * mesh.triangles.size());
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    std::memcpy(bytes.data() + kStlHeader, &count, 4);
    char* next = bytes.data() + kStlHeader + 4;
    for (const Triangle& triangle : mesh.triangles) {
        Vec3f corners[3];
        for (int i = 0; i < 3; ++i) {
            const Vec3f p = placed(mesh.positions[triangle[i]], up);
            corners[i] = {p.x * scale, p.y * scale, p.z * scale};
        }
        const Vec3f normal = face_normal(corners[0], corners[1], corners[2]);
        std::memcpy(next, &normal, 12);
        std::memcpy(next + 12, corners, 36);
        next += kStlTriangle;
    }
    files.write(path, bytes);
}

}  // namespace

extern const MeshFormat stl_format = {
    .extension = ".stl",
    .holds = "binary, triangles alone, for CAD, in `export.stl_unit`; for printing with `export.solid: base`",
    .write = write_stl,
    .describe = inspect::describe_stl,
    .body_unit_mm = 1,
};

}  // namespace hexrelief::exporters
