// PLY, binary little endian, with vertex colours taken from the texture.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "exporters/core/mesh_format.h"
#include "exporters/inspect/describe_formats.h"

namespace hexrelief::exporters {
namespace {

using Colour = std::array<std::uint8_t, 3>;

// Samples bilinearly; pixel centres are at +0.5, and the border's colour continues outside the image.
Colour sample(const Image& image, const Vec2f& texcoord) {
    const float x = std::clamp(texcoord.x * image.width - 0.5f, 0.f, image.width - 1.f);
    const float y = std::clamp(texcoord.y * image.height - 0.5f, 0.f, image.height - 1.f);
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
    const float fx = x - x0, fy = y - y0;
    Colour out;
    for (int i = 0; i < 3; ++i) {
        const int c = image.channels == 3 ? i : 0;
        const float top = image.at(x0, y0)[c] * (1 - fx) + image.at(x1, y0)[c] * fx;
        const float bottom = image.at(x0, y1)[c] * (1 - fx) + image.at(x1, y1)[c] * fx;
        out[i] = static_cast<std::uint8_t>(std::lround(top * (1 - fy) + bottom * fy));
    }
    return out;
}

std::string header(const Scene& scene, UpAxis up, bool normals, bool texcoords, bool colours) {
    const SurfaceMesh& mesh = *scene.mesh;
    std::string text = "ply\nformat binary_little_endian 1.0\ncomment " + scene.generator + "\n";
    text +=
        std::string("comment ") + (mesh.metric ? "metres" : "relative units") + ", " + axes_text(up) + "\n";
    if (!mesh.provenance.empty())
        text += "comment provenance: the cameras that saw a vertex, 0 both, 1 left, 2 right, 3 nobody" +
                std::string(std::ranges::count(mesh.provenance, Provenance::filled) > 0 ? ", 4 filled" : "") +
                "\n";
    text += "element vertex " + std::to_string(mesh.positions.size()) + "\n";
    text += "property float x\nproperty float y\nproperty float z\n";
    if (normals) text += "property float nx\nproperty float ny\nproperty float nz\n";
    if (texcoords) text += "property float s\nproperty float t\n";
    if (colours) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    if (!mesh.provenance.empty()) text += "property uchar provenance\n";
    text += "element face " + std::to_string(mesh.triangles.size()) + "\n";
    return text + "property list uchar int vertex_indices\nend_header\n";
}

void write_ply(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    const SurfaceMesh& mesh = *scene.mesh;
    const bool normals = config.normals != NormalsKind::never && !mesh.normals.empty();
    const bool colours = scene.texture && config.texture != TextureFormat::none;
    const bool texcoords = config.ply_texcoords && config.texcoords && !mesh.texcoords.empty();
    std::string bytes = header(scene, config.up, normals, texcoords, colours);
    const std::size_t vertex_size =
        12 + (normals ? 12 : 0) + (texcoords ? 8 : 0) + (colours ? 3 : 0) + (mesh.provenance.empty() ? 0 : 1);
    const std::size_t start = bytes.size();
    bytes.resize(start + vertex_size * mesh.positions.size() + 13 * mesh.triangles.size());
    char* next = bytes.data() + start;
    const auto put = [&](const void* data, std::size_t size) {
        std::memcpy(next, data, size);
        next += size;
    };
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec3f position = placed(mesh.positions[i], config.up);
        put(&position, 12);
        if (normals) {
            const Vec3f normal = placed(mesh.normals[i], config.up);
            put(&normal, 12);
        }
        if (texcoords) {
            const Vec2f st{mesh.texcoords[i].x, 1 - mesh.texcoords[i].y};
            put(&st, 8);
        }
        if (colours) put(sample(*scene.texture, mesh.texcoords[i]).data(), 3);
        if (!mesh.provenance.empty()) put(&mesh.provenance[i], 1);
    }
    for (const Triangle& triangle : mesh.triangles) {
        *next++ = 3;
        put(triangle.data(), 12);
    }
    files.write(path, bytes);
}

}  // namespace

extern const MeshFormat ply_format = {
    .extension = ".ply",
    .holds = "binary, vertex colours",
    .write = write_ply,
    .describe = inspect::describe_ply,
    .colours = ColourStorage::vertices,
    .origin = OriginSupport::positions,
};

}  // namespace hexrelief::exporters
