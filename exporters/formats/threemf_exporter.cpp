// 3MF, for printing: a zip of XML, in mm.
#include <charconv>
#include <limits>
#include <string>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/solid_body.h"
#include "exporters/formats/stored_zip.h"
#include "exporters/inspect/describe_formats.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

constexpr const char* kTypes = R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
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

template <typename Number>
void append_attribute(std::string& text, const char* name, Number value) {
    char digits[32];
    text.append(name).append("=\"");
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr).append("\"");
}

std::string model_text(const SurfaceMesh& mesh, float scale, std::string generator) {
    for (char& c : generator)
        if (c < ' ' || c > '~' || c == '<' || c == '&') c = '?';
    std::string text =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" "
        "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n"
        "<metadata name=\"Application\">" +
        generator + "</metadata>\n<resources><object id=\"1\" type=\"model\"><mesh>\n<vertices>\n";
    text.reserve(text.size() + mesh.positions.size() * 64 + mesh.triangles.size() * 48);
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
        text += "/>\n";
    }
    return text +
           "</triangles>\n</mesh></object></resources>\n<build><item objectid=\"1\"/></build>\n</model>\n";
}

void write_3mf(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    const bool is_solid = config.solid == SolidKind::base;
    const std::string text =
        is_solid ? model_text(solid_body(*scene.mesh, config.solid_size_mm), 1, scene.generator)
                 : model_text(*scene.mesh, 1000, scene.generator);
    if (text.size() > std::numeric_limits<std::uint32_t>::max() - 4096)
        throw Error(ErrorKind::output,
                    "cannot write '" + path.string() + "': a 3MF ends at 4 GiB; write .stl or .ply");
    StoredZip zip;
    const auto add = [&](const char* name, const std::string& bytes) {
        zip.add(name, bytes.data(), bytes.size());
    };
    add("[Content_Types].xml", kTypes);
    add("_rels/.rels", kRelations);
    add("3D/3dmodel.model", text);
    files.write(path, zip.finish());
}

}  // namespace

extern const MeshFormat threemf_format = {
    .extension = ".3mf",
    .holds = "3MF in mm, triangles alone, for printing; `export.solid: base` for a body",
    .write = write_3mf,
    .describe = inspect::describe_3mf,
};

}  // namespace hexrelief::exporters
