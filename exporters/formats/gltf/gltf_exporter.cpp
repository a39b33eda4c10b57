#include "exporters/formats/gltf/gltf_exporter.h"

#include <cctype>
#include <future>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/gltf/gltf_parts.h"
#include "exporters/images/texture.h"
#include "exporters/inspect/describe_formats.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::exporters {
namespace {

struct GltfDocument {
    std::string json;
    std::vector<std::uint8_t> buffer;
    EncodedTexture texture;  // contents of the file at texture_path(); empty = no such file
};

std::filesystem::path buffer_path(std::filesystem::path path) {
    return path.replace_extension(".bin");
}

constexpr const char* kUnlitExtension = "KHR_materials_unlit";
constexpr const char* kWebpExtension = "EXT_texture_webp";
constexpr const char* kLodExtension = "MSFT_lod";
constexpr const char* kTransformExtension = "KHR_texture_transform";

using Value = tinygltf::Value;
using Json = nlohmann::ordered_json;

// Makes a black material that emits its texture, for programs that do not know the unlit one. The texture is
// also the base colour's, times black, for programs that do not support emission or ignore the black factor.
void make_emissive(tinygltf::Material& material) {
    const tinygltf::TextureInfo& base = material.pbrMetallicRoughness.baseColorTexture;
    material.pbrMetallicRoughness.baseColorFactor = {0, 0, 0, 1};
    material.emissiveTexture = base;
    material.emissiveFactor = {1, 1, 1};
}

void add_textured_material(GltfParts& parts, const EncodedTexture& texture, bool embedded,
                           const std::array<double, 2>& texcoord_scale, MaterialKind kind) {
    tinygltf::Model& model = parts.model;
    tinygltf::Image image;
    image.name = "texture";
    image.mimeType = texture.mime_type;
    image.bufferView = 0;
    if (embedded)
        image.bufferView = add_view(parts, texture.bytes.data(), texture.bytes.size(), kNoTarget, "texture");
    model.images.push_back(image);

    tinygltf::Sampler sampler;
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
    sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    model.samplers.push_back(sampler);

    tinygltf::Texture reference;
    reference.sampler = 0;
    if (texture.mime_type == "image/webp") {  // no other image to fall back on, so the extension is required
        reference.extensions[kWebpExtension] = Value(Value::Object{{"source", Value(0)}});
        use_extension(parts, kWebpExtension, true);
    } else {
        reference.source = 0;
    }
    model.textures.push_back(reference);

    tinygltf::Material& material = model.materials.emplace_back();
    tinygltf::TextureInfo& info = material.pbrMetallicRoughness.baseColorTexture;
    info.index = 0;
    if (texcoord_scale[0] != 1 || texcoord_scale[1] != 1) {
        Value::Array scale = {Value(texcoord_scale[0]), Value(texcoord_scale[1])};
        info.extensions[kTransformExtension] = Value(Value::Object{{"scale", Value(std::move(scale))}});
        use_extension(parts, kTransformExtension, true);
    }
    if (kind == MaterialKind::emissive) make_emissive(material);
    if (kind == MaterialKind::unlit) {
        material.extensions[kUnlitExtension] = Value(Value::Object{});
        use_extension(parts, kUnlitExtension, false);
    }
}

GltfGeometry add_geometry(GltfParts& parts, const TexturedMesh& textured, const Scene& scene,
                          const ExportConfig& config) {
    switch (config.compression) {
        case Compression::draco:
            return add_draco(parts, textured, scene.camera, config, scene.threads);
        case Compression::none:
            break;
        case Compression::quantized:
            return add_quantized(parts, textured, scene.camera, config, false);
        case Compression::meshopt:
            return add_quantized(parts, textured, scene.camera, config, true);
    }
    return add_plain(parts, textured);
}

int add_mesh_node(tinygltf::Model& model, const GltfGeometry& geometry, const std::string& name) {
    tinygltf::Mesh& mesh = model.meshes.emplace_back();
    mesh.name = name;
    mesh.primitives.push_back(geometry.primitive);
    tinygltf::Node& node = model.nodes.emplace_back();
    node.name = name;
    node.mesh = static_cast<int>(model.meshes.size()) - 1;
    const auto& [translation, scale] = geometry.transform;
    if (scale != FileTransform().scale || translation != FileTransform().translation) {
        node.translation.assign(translation.begin(), translation.end());
        node.scale.assign(scale.begin(), scale.end());
    }
    return static_cast<int>(model.nodes.size()) - 1;
}

// Says that a body is closed. Draco's decoders and meshopt's coder order and join vertices as they like.
void add_manifold(GltfParts& parts, tinygltf::Mesh& mesh) {
    constexpr const char* kManifold = "EXT_mesh_manifold";
    const tinygltf::Primitive& primitive = mesh.primitives[0];
    Value::Object attributes = {{"POSITION", Value(primitive.attributes.at("POSITION"))}};
    Value::Object manifold = {{"attributes", Value(std::move(attributes))},
                              {"indices", Value(primitive.indices)},
                              {"mode", Value(primitive.mode)}};
    mesh.extensions[kManifold] = Value(Value::Object{{"manifoldPrimitive", Value(std::move(manifold))}});
    use_extension(parts, kManifold, false);
}

// Links the levels of detail. The finest level is in the scene and names the nodes of the others, which only
// readers of the extension see. Each level has about a quarter of the triangles of the one before it, so it
// looks the same if it covers a quarter of the screen.
void link_levels(tinygltf::Model& model, const std::vector<int>& nodes) {
    if (nodes.size() < 2) return;
    Value::Array ids, coverage;
    double share = 0.25;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (i > 0) ids.emplace_back(nodes[i]);
        coverage.emplace_back(i + 1 < nodes.size() ? share : 0.0);
        share /= 4;
    }
    tinygltf::Node& finest = model.nodes[nodes[0]];
    finest.extensions[kLodExtension] = Value(Value::Object{{"ids", Value(std::move(ids))}});
    finest.extras = Value(Value::Object{{"MSFT_screencoverage", Value(std::move(coverage))}});
    model.extensionsUsed.emplace_back(kLodExtension);
}

bool has_camera(const Scene& scene, const ExportConfig& config) {
    const Calibration* camera = scene.camera;
    return config.camera && camera && camera->focal_px > 0 && camera->width > 0 && camera->height > 0;
}

GltfParts build_parts(const Scene& scene, const ExportConfig& config, bool embedded,
                      EncodedTexture& texture) {
    GltfParts parts;
    tinygltf::Model& model = parts.model;
    model.asset.version = "2.0";
    model.asset.generator = scene.generator;
    model.asset.copyright = config.copyright;
    std::vector<TexturedMesh> levels = textured_levels(scene, config);
    if (config.lod_storage == LevelStorage::files) levels.resize(1);
    std::future<EncodedTexture> encoded;
    if (levels[0].textured)
        encoded = start_work(scene.threads, [&] { return encode_texture(scene, levels[0], config); });
    std::vector<GltfGeometry> geometries;
    for (const TexturedMesh& level : levels) geometries.push_back(add_geometry(parts, level, scene, config));
    if (levels[0].textured) {
        texture = encoded.get();
        add_textured_material(parts, texture, embedded, geometries[0].texcoord_scale, config.material);
    } else {
        model.materials.emplace_back().pbrMetallicRoughness.baseColorFactor = {0.5, 0.5, 0.5, 1};
    }
    tinygltf::Material& material = model.materials[0];
    material.name = "relief";
    material.doubleSided = true;
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 1;

    std::vector<int> nodes;
    for (GltfGeometry& geometry : geometries) {
        geometry.primitive.mode = TINYGLTF_MODE_TRIANGLES;
        geometry.primitive.material = 0;
        for (std::size_t k = 0; k < 3; ++k) geometry.transform.translation[k] += scene.origin_m[k];
        const std::string name = nodes.empty() ? "relief" : "relief_lod" + std::to_string(nodes.size());
        nodes.push_back(add_mesh_node(model, geometry, name));
        if (scene.is_body && config.compression == Compression::none)
            add_manifold(parts, model.meshes.back());
    }
    link_levels(model, nodes);
    tinygltf::Scene& root = model.scenes.emplace_back();
    root.name = "hexrelief";
    root.nodes = {nodes[0]};
    if (has_camera(scene, config)) root.nodes.push_back(add_camera(parts, *scene.camera, *scene.mesh));
    if (scene.shift_m != std::array<double, 3>{}) {
        tinygltf::Node& above = model.nodes.emplace_back();
        above.name = "origin";
        above.translation = {scene.shift_m.begin(), scene.shift_m.end()};
        above.children = root.nodes;
        root.nodes = {static_cast<int>(model.nodes.size()) - 1};
    }
    model.defaultScene = 0;
    return parts;
}

void add_buffers(Json& json, const GltfParts& parts, const std::string& uri) {
    constexpr const char* kMeshopt = "EXT_meshopt_compression";
    Json buffer = {{"byteLength", parts.buffer.size()}};
    if (!uri.empty()) buffer["uri"] = percent_encoded(uri);
    json["buffers"] = Json::array({buffer});
    if (parts.meshopt_views.empty()) return;
    Json fallback = {{"byteLength", parts.fallback_bytes}};
    fallback["extensions"][kMeshopt]["fallback"] = true;
    json["buffers"].push_back(fallback);
    for (const MeshoptView& view : parts.meshopt_views) {
        Json& extension = json["bufferViews"][view.view]["extensions"][kMeshopt];
        extension = {{"buffer", 0},
                     {"byteOffset", view.offset},
                     {"byteLength", view.bytes},
                     {"byteStride", view.stride},
                     {"count", view.count},
                     {"mode", view.mode}};
        if (view.octahedral) extension["filter"] = "OCTAHEDRAL";
    }
}

// path: the document's, beside which the buffer and the texture have files; empty = it holds both (.glb).
GltfDocument build_gltf(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path) {
    GltfDocument out;
    const bool embedded = path.empty();
    GltfParts parts = build_parts(scene, config, embedded, out.texture);
    std::stringstream stream;
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&parts.model, stream, false, false))
        throw std::logic_error("tinygltf did not serialise the scene");
    // tinygltf's stream writer can only embed buffers and images as base64, copies them several times, and
    // cuts integers in extras to 32 bits: so these parts are added here.
    auto json = Json::parse(stream.str());
    add_buffers(json, parts, embedded ? "" : buffer_path(path).filename().string());
    if (!out.texture.bytes.empty() && !embedded)
        json["images"][0] = {
            {"name", "texture"},
            {"uri", percent_encoded(texture_path(path, out.texture.mime_type).filename().string())}};
    if (!scene.extras_json.empty()) {
        auto extras = Json::parse(scene.extras_json, nullptr, false);
        if (!extras.is_object()) throw std::logic_error("the scene's extras are not a JSON object");
        json["asset"]["extras"] = std::move(extras);
    }
    constexpr auto kReplace = Json::error_handler_t::replace;  // paths in extras may not be UTF-8
    out.json = json.dump(embedded ? -1 : 2, ' ', false, kReplace);
    out.buffer = std::move(parts.buffer);
    return out;
}

void append_u32(std::vector<std::uint8_t>& bytes, std::size_t value) {
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

// Appends one chunk of a GLB, padded to a multiple of 4.
template <typename Container>
void append_chunk(std::vector<std::uint8_t>& bytes, const char* type, const Container& data, char filler) {
    append_u32(bytes, (data.size() + 3) / 4 * 4);
    bytes.insert(bytes.end(), type, type + 4);
    bytes.insert(bytes.end(), data.begin(), data.end());
    bytes.resize((bytes.size() + 3) / 4 * 4, static_cast<std::uint8_t>(filler));
}

}  // namespace

std::string percent_encoded(std::string_view path) {
    constexpr char kHex[] = "0123456789ABCDEF";
    std::string out;
    for (const char c : path) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 128 && (std::isalnum(byte) || std::string_view("-_.~/").find(c) != std::string_view::npos))
            out += c;
        else
            out += {'%', kHex[byte >> 4], kHex[byte & 15]};
    }
    return out;
}

std::vector<std::uint8_t> glb_bytes(const Scene& scene, const ExportConfig& config,
                                    const std::filesystem::path& path) {
    const GltfDocument document = build_gltf(scene, config, {});
    constexpr std::size_t kHeader = 12, kChunkHeader = 8;
    const std::size_t size = kHeader + kChunkHeader + (document.json.size() + 3) / 4 * 4 + kChunkHeader +
                             (document.buffer.size() + 3) / 4 * 4;
    check_32_bits(path, size, "a GLB ends at 4 GiB; set export.compression to draco or write .gltf");
    std::vector<std::uint8_t> bytes;
    bytes.reserve(size);
    for (const char c : {'g', 'l', 'T', 'F'}) bytes.push_back(static_cast<std::uint8_t>(c));
    append_u32(bytes, 2);
    append_u32(bytes, size);
    append_chunk(bytes, "JSON", document.json, ' ');
    append_chunk(bytes, "BIN\0", document.buffer, '\0');
    return bytes;
}

namespace {

void write_glb(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    files.write(path, glb_bytes(scene, config, path));
}

void write_gltf(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files) {
    const GltfDocument document = build_gltf(scene, config, path);
    files.write(path, document.json + "\n");
    files.write(buffer_path(path), document.buffer);
    const EncodedTexture& texture = document.texture;
    if (!texture.bytes.empty()) files.write(texture_path(path, texture.mime_type), texture.bytes);
}

}  // namespace

extern constexpr MeshFormat glb_format = {
    .extension = ".glb",
    .holds = "glTF 2.0 in one file, with JPEG, PNG or WebP texture",
    .write = write_glb,
    .describe = inspect::describe_glb,
    .colours = ColourStorage::texture,
    .has_material = true,
    .compression = std::nullopt,
    .levels = LevelSupport::by_config,
    .origin = OriginSupport::node,
    .body_unit_mm = 1000,
};

extern constexpr MeshFormat gltf_format = [] {
    MeshFormat format = glb_format;
    format.extension = ".gltf";
    format.holds = "the same, with `.bin` and texture beside";
    format.write = write_gltf;
    format.describe = inspect::describe_gltf;
    format.companion = ".bin";
    return format;
}();

}  // namespace hexrelief::exporters
