// 3MF, for printing: an uncompressed zip of XML, in mm, and its texture.
#include <charconv>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/stored_zip.h"
#include "exporters/images/texture.h"
#include "exporters/inspect/describe_formats.h"

namespace hexrelief::exporters {
namespace {

constexpr std::string_view kTypes = R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="jpg" ContentType="image/jpeg"/>
<Default Extension="png" ContentType="image/png"/>
<Default Extension="rels"
 ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model"
 ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";
constexpr std::string_view kRelations = R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";

std::string texture_relations(const std::string& name) {
    return R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target=")" +
           name + R"(" Id="rel0"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"/>
</Relationships>
)";
}

template <typename Number>
void append_element(std::string& text, const char* name,
                    std::initializer_list<std::pair<const char*, Number>> attributes) {
    text.append("<").append(name);
    for (const auto& [attribute, value] : attributes) {
        char digits[32];
        text.append(" ").append(attribute).append("=\"");
        text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr).append("\"");
    }
    text += "/>\n";
}

// Appends a texture (resource 1) and each vertex's place on it (resource 2), from the bottom left.
void append_texture(std::string& text, const EncodedTexture& texture, const std::string& name,
                    const std::vector<Vec2f>& texcoords) {
    text += "<m:texture2d id=\"1\" path=\"" + name + "\" contenttype=\"" + texture.mime_type +
            "\" tilestyleu=\"clamp\" tilestylev=\"clamp\"/>\n<m:texture2dgroup id=\"2\" texid=\"1\">\n";
    for (const Vec2f& t : texcoords) append_element<float>(text, "m:tex2coord", {{"u", t.x}, {"v", 1 - t.y}});
    text += "</m:texture2dgroup>\n";
}

// texture_name: absolute in the archive; empty = no texture.
std::string model_text(const Scene& scene, const SurfaceMesh& mesh, const EncodedTexture& texture,
                       const std::string& texture_name) {
    std::string generator = scene.generator;
    for (char& c : generator)
        if (c < ' ' || c > '~' || c == '<' || c == '&') c = '?';
    const bool is_textured = !texture_name.empty();
    std::string text =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" "
        "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
        "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">\n"
        "<metadata name=\"Application\">" +
        generator + "</metadata>\n<resources>\n";
    text.reserve(text.size() + mesh.positions.size() * 112 + mesh.triangles.size() * 80);
    if (is_textured) append_texture(text, texture, texture_name, mesh.texcoords);
    text += std::string("<object id=\"3\" type=\"model\"") + (is_textured ? " pid=\"2\" pindex=\"0\"" : "") +
            "><mesh>\n<vertices>\n";
    const float scale = scene.is_body ? 1 : 1000;
    for (const Vec3f& p : mesh.positions)
        append_element<float>(text, "vertex", {{"x", p.x * scale}, {"y", p.y * scale}, {"z", p.z * scale}});
    text += "</vertices>\n<triangles>\n";
    for (const auto& [a, b, c] : mesh.triangles)
        if (is_textured)
            append_element<std::uint32_t>(text, "triangle",
                                          {{"v1", a}, {"v2", b}, {"v3", c}, {"p1", a}, {"p2", b}, {"p3", c}});
        else
            append_element<std::uint32_t>(text, "triangle", {{"v1", a}, {"v2", b}, {"v3", c}});
    return text +
           "</triangles>\n</mesh></object>\n</resources>\n<build><item objectid=\"3\"/></build>\n</model>\n";
}

void write_3mf(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    const auto [textured, texture, texture_name] = archived_mesh(scene, config, "/3D/Textures/relief");
    const std::string text = model_text(scene, textured.mesh, texture, texture_name);
    StoredZip zip;
    zip.add("[Content_Types].xml", kTypes);
    zip.add("_rels/.rels", kRelations);
    zip.add("3D/3dmodel.model", text);
    if (textured.textured) {
        zip.add("3D/_rels/3dmodel.model.rels", texture_relations(texture_name));
        zip.add(texture_name.substr(1), texture.bytes);
    }
    const std::vector<std::uint8_t> bytes = zip.finish();
    check_32_bits(path, bytes.size(), "a 3MF ends at 4 GiB; write .stl or .ply");
    files.write(path, bytes);
}

}  // namespace

extern const MeshFormat threemf_format = {
    .extension = ".3mf",
    .holds = "3MF in mm, with JPEG or PNG texture, for printing; `export.solid: base` for a body",
    .write = write_3mf,
    .describe = inspect::describe_3mf,
    .colours = ColourStorage::texture,
    .body_unit_mm = 1,
};

}  // namespace hexrelief::exporters
