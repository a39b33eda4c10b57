// 3MF, for printing: an uncompressed zip of XML, in mm, and its texture.
#include <charconv>
#include <limits>
#include <string>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/stored_zip.h"
#include "exporters/images/texture.h"
#include "exporters/inspect/describe_formats.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

constexpr const char* kTypes = R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="jpg" ContentType="image/jpeg"/>
<Default Extension="png" ContentType="image/png"/>
<Default Extension="rels"
 ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model"
 ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";
constexpr const char* kRelations = R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";

// Returns the relations of the model to a texture.
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
void append_attribute(std::string& text, const char* name, Number value) {
    char digits[32];
    text.append(name).append("=\"");
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr).append("\"");
}

// Appends a texture (resource 1) and each vertex's place on it (resource 2), from the bottom left.
void append_texture(std::string& text, const EncodedTexture& texture, const std::string& name,
                    const std::vector<Vec2f>& texcoords) {
    text += "<m:texture2d id=\"1\" path=\"" + name + "\" contenttype=\"" + texture.mime_type +
            "\" tilestyleu=\"clamp\" tilestylev=\"clamp\"/>\n<m:texture2dgroup id=\"2\" texid=\"1\">\n";
    for (const Vec2f& t : texcoords) {
        append_attribute(text += "<m:tex2coord", " u", t.x);
        append_attribute(text, " v", 1 - t.y);
        text += "/>\n";
    }
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
    for (const Vec3f& p : mesh.positions) {
        append_attribute(text += "<vertex", " x", p.x * scale);
        append_attribute(text, " y", p.y * scale);
        append_attribute(text, " z", p.z * scale);
        text += "/>\n";
    }
    text += "</vertices>\n<triangles>\n";
    for (const Triangle& t : mesh.triangles) {
        append_attribute(text += "<triangle", " v1", t[0]);
        append_attribute(text, " v2", t[1]);
        append_attribute(text, " v3", t[2]);
        if (is_textured) {
            append_attribute(text, " p1", t[0]);
            append_attribute(text, " p2", t[1]);
            append_attribute(text, " p3", t[2]);
        }
        text += "/>\n";
    }
    return text +
           "</triangles>\n</mesh></object>\n</resources>\n<build><item objectid=\"3\"/></build>\n</model>\n";
}

void write_3mf(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    const auto [textured, texture, texture_name] = archived_mesh(scene, config, "/3D/Textures/relief");
    const std::string text = model_text(scene, textured.mesh, texture, texture_name);
    constexpr std::size_t kHeaders = 4096;  // more than those of all files
    if (text.size() + texture.bytes.size() + kHeaders > std::numeric_limits<std::uint32_t>::max())
        throw Error(ErrorKind::output,
                    "cannot write '" + path.string() + "': a 3MF ends at 4 GiB; write .stl or .ply");
    StoredZip zip;
    const auto add = [&](const std::string& name, const auto& bytes) {
        zip.add(name, bytes.data(), bytes.size());
    };
    add("[Content_Types].xml", std::string(kTypes));
    add("_rels/.rels", std::string(kRelations));
    add("3D/3dmodel.model", text);
    if (textured.textured) {
        add("3D/_rels/3dmodel.model.rels", texture_relations(texture_name));
        add(texture_name.substr(1), texture.bytes);
    }
    files.write(path, zip.finish());
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
