// USDZ: a USD text file and its texture in an uncompressed zip, as phones show it.
#include <charconv>
#include <initializer_list>
#include <limits>
#include <string>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/stored_zip.h"
#include "exporters/images/texture.h"
#include "exporters/inspect/describe_formats.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

// Appends numbers in the shortest text that reads back as the same float.
void append_tuple(std::string& text, std::initializer_list<float> values) {
    char separator = '(';
    for (const float value : values) {
        char digits[32];
        text += separator;
        text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
        separator = ',';
    }
    text += ')';
}

template <typename Values, typename Append>
void append_array(std::string& text, const char* name, const Values& values, const char* metadata,
                  Append append) {
    text += std::string("        ") + name + " = [";
    bool first = true;
    for (const auto& value : values) {
        if (!first) text += ',';
        first = false;
        append(value);
    }
    text += std::string("]") + metadata + "\n";
}

void append_mesh(std::string& text, const SurfaceMesh& mesh) {
    constexpr const char* kPerVertex = " (\n            interpolation = \"vertex\"\n        )";
    const auto vector = [&](const Vec3f& v) { append_tuple(text, {v.x, v.y, v.z}); };
    text += R"(    def Mesh "surface" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        uniform bool doubleSided = 1
)";
    const Bounds bounds = bounds_of(mesh.positions);
    append_array(text, "float3[] extent", std::initializer_list<Vec3f>{bounds.low, bounds.high}, "", vector);
    append_array(text, "int[] faceVertexCounts", mesh.triangles, "", [&](const Triangle&) { text += '3'; });
    append_array(text, "int[] faceVertexIndices", mesh.triangles, "", [&](const Triangle& t) {
        text += std::to_string(t[0]) + "," + std::to_string(t[1]) + "," + std::to_string(t[2]);
    });
    append_array(text, "point3f[] points", mesh.positions, "", vector);
    if (!mesh.normals.empty()) append_array(text, "normal3f[] normals", mesh.normals, kPerVertex, vector);
    if (!mesh.texcoords.empty())  // USD has v = 0 at the bottom
        append_array(text, "texCoord2f[] primvars:st", mesh.texcoords, kPerVertex, [&](const Vec2f& t) {
            append_tuple(text, {t.x, 1 - t.y});
        });
    text += R"(        uniform token subdivisionScheme = "none"
        rel material:binding = </relief/material>
    }
)";
}

// Appends the material; without a texture (empty texture_name) it is lit grey.
void append_material(std::string& text, const std::string& texture_name, MaterialKind kind) {
    constexpr const char* kTexture = ".connect = </relief/material/texture.outputs:rgb>\n";
    const bool is_textured = !texture_name.empty(), is_lit = kind == MaterialKind::lit;
    text += R"(    def Material "material"
    {
        token outputs:surface.connect = </relief/material/surface.outputs:surface>
        def Shader "surface"
        {
            uniform token info:id = "UsdPreviewSurface"
)";
    text += std::string("            color3f inputs:diffuseColor") + (!is_textured ? " = (0.5, 0.5, 0.5)\n"
                                                                      : is_lit     ? kTexture
                                                                                   : " = (0, 0, 0)\n");
    if (is_textured && !is_lit) text += std::string("            color3f inputs:emissiveColor") + kTexture;
    text += R"(            float inputs:metallic = 0
            float inputs:roughness = 1
            token outputs:surface
        }
)";
    if (is_textured)
        text += R"(        def Shader "texture"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @)" +
                texture_name + R"(@
            float2 inputs:st.connect = </relief/material/coordinates.outputs:result>
            token inputs:sourceColorSpace = "sRGB"
            token inputs:wrapS = "clamp"
            token inputs:wrapT = "clamp"
            float3 outputs:rgb
        }
        def Shader "coordinates"
        {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }
)";
    text += "    }\n";
}

std::string usd_text(const Scene& scene, const SurfaceMesh& mesh, const std::string& texture_name,
                     MaterialKind kind) {
    std::string generator = scene.generator;
    for (char& c : generator)
        if (c < ' ' || c > '~' || c == '"' || c == '\\') c = '?';
    std::string text = "#usda 1.0\n(\n    defaultPrim = \"relief\"\n    doc = \"" + generator +
                       "\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\ndef Xform \"relief\"\n{\n";
    text.reserve(text.size() + mesh.positions.size() * 80 + mesh.triangles.size() * 24 + 2048);
    append_mesh(text, mesh);
    append_material(text, texture_name, kind);
    return text + "}\n";
}

// Writes the texture as JPEG or PNG; WebP becomes JPEG, because USDZ does not support WebP.
void write_usdz(const Scene& scene, const ExportConfig& asked, const std::filesystem::path& path,
                FileTransaction& files) {
    ExportConfig config = asked;
    if (config.texture == TextureFormat::webp) config.texture = TextureFormat::jpeg;
    const TexturedMesh textured = textured_mesh(scene, config);
    EncodedTexture texture;
    std::string texture_name;
    if (textured.textured) {
        texture = encode_texture(scene, textured, config);
        texture_name = texture.mime_type == "image/png" ? "texture.png" : "texture.jpg";
    }
    const std::string text = usd_text(scene, textured.mesh, texture_name, config.material);
    constexpr std::size_t kHeaders = 4096;  // more than those of two files
    if (text.size() + texture.bytes.size() + kHeaders > std::numeric_limits<std::uint32_t>::max())
        throw Error(ErrorKind::output,
                    "cannot write '" + path.string() + "': a USDZ ends at 4 GiB; write .glb or .ply");
    StoredZip zip;
    zip.add("relief.usda", text.data(), text.size());  // viewers show the first file
    if (!texture_name.empty()) zip.add(texture_name, texture.bytes.data(), texture.bytes.size());
    files.write(path, zip.finish());
}

}  // namespace

extern const MeshFormat usdz_format = {
    .extension = ".usdz",
    .holds = "USD text with JPEG or PNG texture, for phones",
    .write = write_usdz,
    .describe = inspect::describe_usdz,
    .colours = ColourStorage::texture,
    .has_material = true,
    .origin = OriginSupport::positions,
    .usual_origin = FileOrigin::base,
};

}  // namespace hexrelief::exporters
