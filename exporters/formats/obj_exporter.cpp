// Wavefront OBJ with a material library and a texture file beside it.
#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "exporters/core/mesh_format.h"
#include "exporters/images/texture.h"
#include "exporters/inspect/describe_formats.h"

namespace hexrelief::exporters {
namespace {

// Appends each number in the shortest text that reads back as the same float; std::ostream takes ten times as
// long and loses bits.
void append_line(std::string& text, const char* keyword, std::initializer_list<float> values) {
    text += keyword;
    for (const float value : values) {
        char digits[32];
        text += ' ';
        text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    }
    text += '\n';
}

void append(std::string& text, std::uint32_t value) {
    char digits[16];
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

std::string material_text(const Scene& scene, const std::string& texture_name) {
    std::string text = "# " + scene.generator + "\nnewmtl relief\n";
    // illum 0: colour only, no light, so that the mesh looks like the photograph.
    if (texture_name.empty()) return text + "Ka 0 0 0\nKd 0.7 0.7 0.7\nKs 0 0 0\nd 1\nillum 1\n";
    return text + "Ka 0 0 0\nKd 1 1 1\nKs 0 0 0\nd 1\nillum 0\nmap_Kd " + texture_name + "\n";
}

// Numbers the positions that differ: vertices that differ in their texture's place alone share one.
struct Places {
    std::vector<std::uint32_t> of;      // each vertex's position, counted from 1
    std::vector<std::uint32_t> vertex;  // one of each position
};
Places places_of(const std::vector<Vec3f>& positions) {
    const auto key = [&](std::uint32_t i) {
        return std::tuple(positions[i].x, positions[i].y, positions[i].z, i);
    };
    std::vector<std::uint32_t> order(positions.size()), first(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, key);
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] =
            i > 0 && positions[order[i]] == positions[order[i - 1]] ? first[order[i - 1]] : order[i];
    Places places{std::vector<std::uint32_t>(positions.size()), {}};
    for (std::uint32_t i = 0; i < positions.size(); ++i) {  // a position's first vertex comes first
        if (first[i] == i) places.vertex.push_back(i);
        places.of[i] = first[i] == i ? static_cast<std::uint32_t>(places.vertex.size()) : places.of[first[i]];
    }
    return places;
}

std::string mesh_text(const SurfaceMesh& mesh, const std::string& generator, UpAxis up,
                      const std::string& material_name) {
    const bool normals = !mesh.normals.empty(), texcoords = !mesh.texcoords.empty();
    std::string text;
    text.reserve(mesh.positions.size() * 90 + mesh.triangles.size() * 48 + 256);
    text += "# " + generator + "\n# " + (mesh.metric ? "metres" : "relative units") + ", " + axes_text(up) +
            "\nmtllib " + material_name + "\no relief\n";
    const Places places = places_of(mesh.positions);
    for (const std::uint32_t i : places.vertex) {
        const Vec3f p = placed(mesh.positions[i], up);
        append_line(text, "v", {p.x, p.y, p.z});
    }
    // OBJ has v = 0 at the bottom.
    for (const Vec2f& t : mesh.texcoords) append_line(text, "vt", {t.x, 1 - t.y});
    for (const Vec3f& normal : mesh.normals) {
        const Vec3f n = placed(normal, up);
        append_line(text, "vn", {n.x, n.y, n.z});
    }
    text += "usemtl relief\n";
    for (const Triangle& triangle : mesh.triangles) {
        text += 'f';
        for (const std::uint32_t vertex : triangle) {
            text += ' ';
            append(text, places.of[vertex]);
            if (texcoords || normals) text += '/';
            if (texcoords) append(text, vertex + 1);
            if (normals) {
                text += '/';
                append(text, vertex + 1);
            }
        }
        text += '\n';
    }
    return text;
}

void write_obj(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    std::filesystem::path material_path = path;
    material_path.replace_extension(".mtl");
    const TexturedMesh textured = textured_mesh(scene, config);
    const EncodedTexture texture =
        textured.textured ? encode_texture(scene, textured, config) : EncodedTexture{};
    const std::filesystem::path image_path = texture_path(path, texture.mime_type);
    files.write(path,
                mesh_text(textured.mesh, scene.generator, config.up, material_path.filename().string()));
    files.write(material_path, material_text(scene, textured.textured ? image_path.filename().string() : ""));
    if (textured.textured) files.write(image_path, texture.bytes);
}

}  // namespace

extern const MeshFormat obj_format = {
    .extension = ".obj",
    .holds = "with `.mtl` and texture",
    .write = write_obj,
    .describe = inspect::describe_obj,
    .colours = ColourStorage::texture,
    .origin = OriginSupport::positions,
    .companion = ".mtl",
    .names_companions_in_lines = true,
};

}  // namespace hexrelief::exporters
