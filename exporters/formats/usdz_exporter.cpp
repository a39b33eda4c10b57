// USDZ: a USD text file and its texture in an uncompressed zip, as phones show it.
#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <iterator>
#include <string>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/stored_zip.h"
#include "exporters/images/texture.h"
#include "exporters/inspect/describe_formats.h"
#include "pipeline/data/bounds.h"

namespace hexrelief::exporters {
namespace {

constexpr int kAllDigits = 9;  // decimals from which on a number gets the shortest text of the same float

// Returns the fewest decimals with which rounding errs by at most `most`.
int decimals_within(double most) {
    int decimals = 0;
    for (double error = 0.5; error > most && decimals < kAllDigits; error /= 10) ++decimals;
    return decimals;
}

// Appends numbers without zeros at their ends.
void append_tuple(std::string& text, std::initializer_list<float> values, int decimals = kAllDigits) {
    char separator = '(';
    for (const float value : values) {
        char digits[64];
        text += separator;
        separator = ',';
        char* end =
            decimals < kAllDigits
                ? std::to_chars(digits, std::end(digits), value, std::chars_format::fixed, decimals).ptr
                : std::to_chars(digits, std::end(digits), value).ptr;
        if (std::find(digits, end, '.') != end && decimals < kAllDigits) {
            while (end[-1] == '0') --end;
            if (end[-1] == '.') --end;
        }
        text.append(digits, end);
    }
    text += ')';
}

// Returns the decimals that keep a vertex within export.tolerance_px as the camera sees it: half of that
// across, and as much in depth, which moves what is up to 45 degrees off the axis by the other half.
int position_decimals(const Scene& scene, const ExportConfig& config, std::size_t vertex) {
    const Calibration* const camera = scene.camera;
    if (!camera || scene.grid_step_m > 0 || scene.mesh->disparities.size() <= vertex) return kAllDigits;
    const double shift = scene.mesh->disparities[vertex] + camera->doffs_px;
    return shift > 0 ? decimals_within(config.tolerance_px / 2 * camera->baseline_m / shift) : kAllDigits;
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

void append_mesh(std::string& text, const Scene& scene, const ExportConfig& config,
                 const TexturedMesh& textured) {
    const SurfaceMesh& mesh = textured.mesh;
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
    std::size_t vertex = 0;
    append_array(text, "point3f[] points", mesh.positions, "", [&](const Vec3f& p) {
        append_tuple(text, {p.x, p.y, p.z}, position_decimals(scene, config, vertex++));
    });
    const int normal_decimals = decimals_within(config.tolerance_deg * 0.01);  // of all three at once
    if (!mesh.normals.empty())
        append_array(text, "normal3f[] normals", mesh.normals, kPerVertex, [&](const Vec3f& n) {
            append_tuple(text, {n.x, n.y, n.z}, normal_decimals);
        });
    const int decimals =
        decimals_within(config.tolerance_px / std::max(textured.width_px, textured.height_px));
    if (!mesh.texcoords.empty())  // USD has v = 0 at the bottom
        append_array(text, "texCoord2f[] primvars:st", mesh.texcoords, kPerVertex, [&](const Vec2f& t) {
            append_tuple(text, {t.x, 1 - t.y}, decimals);
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

std::string usd_text(const Scene& scene, const ExportConfig& config, const TexturedMesh& textured,
                     const std::string& texture_name) {
    std::string generator = scene.generator;
    for (char& c : generator)
        if (c < ' ' || c > '~' || c == '"' || c == '\\') c = '?';
    std::string text = "#usda 1.0\n(\n    defaultPrim = \"relief\"\n    doc = \"" + generator +
                       "\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\ndef Xform \"relief\"\n{\n";
    text.reserve(text.size() + textured.mesh.positions.size() * 80 + textured.mesh.triangles.size() * 24 +
                 2048);
    append_mesh(text, scene, config, textured);
    append_material(text, texture_name, config.material);
    return text + "}\n";
}

void write_usdz(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files) {
    const auto [textured, texture, texture_name] = archived_mesh(scene, config, "texture");
    const std::string text = usd_text(scene, config, textured, texture_name);
    StoredZip zip;
    zip.add("relief.usda", text);  // viewers show the first file
    if (!texture_name.empty()) zip.add(texture_name, texture.bytes);
    const std::vector<std::uint8_t> bytes = zip.finish();
    check_32_bits(path, bytes.size(), "a USDZ ends at 4 GiB; write .glb or .ply");
    files.write(path, bytes);
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
