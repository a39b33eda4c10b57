#include "exporters/gltf_model.h"

// libdraco exports a tinygltf of its own, built with another layout of the same classes: which of the two a
// call reached would hang on the order of linking (Debian's shared tinygltf crashed that way). So this file
// compiles tinygltf for itself, under another namespace, and without stb, because images come encoded
// already.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define tinygltf hexrelief_tinygltf
#include <tiny_gltf.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "exporters/draco_codec.h"

namespace hexrelief {
namespace {

constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";
constexpr const char* kUnlitExtension = "KHR_materials_unlit";
constexpr int kNoTarget = 0;

std::string percent_encoded(const std::string& name) {
    constexpr char kHex[] = "0123456789ABCDEF";
    std::string out;
    for (const char c : name) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 128 && (std::isalnum(byte) || c == '-' || c == '_' || c == '.' || c == '~')) {
            out += c;
        } else {
            out += {'%', kHex[byte >> 4], kHex[byte & 15]};
        }
    }
    return out;
}

// Appends to the buffer at a multiple of 4, as accessors need it, and returns the view's index.
int add_view(tinygltf::Model& model, std::vector<std::uint8_t>& buffer, const void* data, std::size_t bytes,
             int target, const char* name) {
    buffer.resize((buffer.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer.size();
    view.byteLength = bytes;
    view.target = target;
    view.name = name;
    const auto* begin = static_cast<const std::uint8_t*>(data);
    buffer.insert(buffer.end(), begin, begin + bytes);
    model.bufferViews.push_back(view);
    return static_cast<int>(model.bufferViews.size()) - 1;
}

// view = -1: the data come from an extension.
int add_accessor(tinygltf::Model& model, int view, int component_type, int type, long long count,
                 const char* name) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = static_cast<std::size_t>(count);
    accessor.name = name;
    model.accessors.push_back(accessor);
    return static_cast<int>(model.accessors.size()) - 1;
}

void set_bounds(tinygltf::Accessor& accessor, const Vec3f& low, const Vec3f& high) {
    accessor.minValues = {low.x, low.y, low.z};
    accessor.maxValues = {high.x, high.y, high.z};
}

// 65535 itself is the primitive restart value, so an index may be at most 65534.
bool short_indices(long long vertices) {
    return vertices < 65535;
}

int index_type(long long vertices) {
    return short_indices(vertices) ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                   : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

void add_plain_mesh(tinygltf::Model& model, std::vector<std::uint8_t>& buffer, tinygltf::Primitive& primitive,
                    const SurfaceMesh& mesh, bool with_texcoords) {
    const auto vertices = static_cast<long long>(mesh.positions.size());
    const auto add = [&](const char* attribute, const auto& values, int type, const char* name) {
        const int view = add_view(model, buffer, values.data(), values.size() * sizeof(values[0]),
                                  TINYGLTF_TARGET_ARRAY_BUFFER, name);
        primitive.attributes[attribute] =
            add_accessor(model, view, TINYGLTF_COMPONENT_TYPE_FLOAT, type, vertices, name);
    };
    add("POSITION", mesh.positions, TINYGLTF_TYPE_VEC3, "positions");
    Vec3f low = mesh.positions[0], high = low;
    for (const Vec3f& p : mesh.positions) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    set_bounds(model.accessors.back(), low, high);
    if (!mesh.normals.empty()) add("NORMAL", mesh.normals, TINYGLTF_TYPE_VEC3, "normals");
    if (with_texcoords) add("TEXCOORD_0", mesh.texcoords, TINYGLTF_TYPE_VEC2, "texcoords");

    int view;
    if (short_indices(vertices)) {
        std::vector<std::uint16_t> indices;
        indices.reserve(mesh.triangles.size() * 3);
        for (const Triangle& t : mesh.triangles) {
            for (const std::uint32_t i : t) indices.push_back(static_cast<std::uint16_t>(i));
        }
        view = add_view(model, buffer, indices.data(), indices.size() * sizeof(indices[0]),
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, "indices");
    } else {
        view = add_view(model, buffer, mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle),
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, "indices");
    }
    primitive.indices = add_accessor(model, view, index_type(vertices), TINYGLTF_TYPE_SCALAR,
                                     static_cast<long long>(mesh.triangles.size()) * 3, "indices");
}

// The accessors describe what a decoder returns and have no buffer view: there is no uncompressed fallback,
// so the extension is required.
void add_draco_mesh(tinygltf::Model& model, std::vector<std::uint8_t>& buffer, tinygltf::Primitive& primitive,
                    const SurfaceMesh& mesh, bool with_texcoords, const DracoConfig& config) {
    const DracoMesh draco = encode_draco(mesh, with_texcoords, config);
    tinygltf::Value::Object ids;
    const auto add = [&](const char* attribute, int id, int type, const char* name) {
        if (id < 0) return;
        ids[attribute] = tinygltf::Value(id);
        primitive.attributes[attribute] =
            add_accessor(model, -1, TINYGLTF_COMPONENT_TYPE_FLOAT, type, draco.vertices, name);
    };
    add("POSITION", draco.position_id, TINYGLTF_TYPE_VEC3, "positions");
    set_bounds(model.accessors.back(), draco.min, draco.max);
    add("NORMAL", draco.normal_id, TINYGLTF_TYPE_VEC3, "normals");
    add("TEXCOORD_0", draco.texcoord_id, TINYGLTF_TYPE_VEC2, "texcoords");
    primitive.indices = add_accessor(model, -1, index_type(draco.vertices), TINYGLTF_TYPE_SCALAR,
                                     draco.triangles * 3, "indices");
    const int view = add_view(model, buffer, draco.bytes.data(), draco.bytes.size(), kNoTarget, "draco");
    primitive.extensions[kDracoExtension] = tinygltf::Value(tinygltf::Value::Object{
        {"bufferView", tinygltf::Value(view)}, {"attributes", tinygltf::Value(std::move(ids))}});
    model.extensionsUsed.emplace_back(kDracoExtension);
    model.extensionsRequired.emplace_back(kDracoExtension);
}

// The photograph already holds its light: unlit shows it as it is, in viewers that know the extension; the
// others fall back on a rough dielectric.
void add_textured_material(tinygltf::Model& model, std::vector<std::uint8_t>& buffer,
                           const EncodedTexture& texture, bool embedded) {
    tinygltf::Image image;
    image.name = "texture";
    image.mimeType = texture.mime_type;
    image.bufferView = 0;
    if (embedded) {
        image.bufferView =
            add_view(model, buffer, texture.bytes.data(), texture.bytes.size(), kNoTarget, "texture");
    }
    model.images.push_back(image);

    tinygltf::Sampler sampler;
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
    sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    model.samplers.push_back(sampler);

    tinygltf::Texture reference;
    reference.source = 0;
    reference.sampler = 0;
    model.textures.push_back(reference);

    tinygltf::Material& material = model.materials.emplace_back();
    material.pbrMetallicRoughness.baseColorTexture.index = 0;
    material.extensions[kUnlitExtension] = tinygltf::Value(tinygltf::Value::Object{});
    model.extensionsUsed.emplace_back(kUnlitExtension);
}

tinygltf::Model build_model(const Scene& scene, const ExportConfig& config, const EncodedTexture* texture,
                            bool embedded, std::vector<std::uint8_t>& buffer) {
    tinygltf::Model model;
    model.asset.version = "2.0";
    model.asset.generator = scene.generator;
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = 0;
    if (config.draco.enabled) {
        add_draco_mesh(model, buffer, primitive, *scene.mesh, texture != nullptr, config.draco);
    } else {
        add_plain_mesh(model, buffer, primitive, *scene.mesh, texture != nullptr);
    }
    if (texture) {
        add_textured_material(model, buffer, *texture, embedded);
    } else {
        model.materials.emplace_back().pbrMetallicRoughness.baseColorFactor = {0.5, 0.5, 0.5, 1};
    }
    tinygltf::Material& material = model.materials[0];
    material.name = "relief";
    material.doubleSided = true;
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 1;

    tinygltf::Mesh& mesh = model.meshes.emplace_back();
    mesh.name = "relief";
    mesh.primitives.push_back(primitive);
    tinygltf::Node& node = model.nodes.emplace_back();
    node.name = "relief";
    node.mesh = 0;
    tinygltf::Scene& root = model.scenes.emplace_back();
    root.name = "hexrelief";
    root.nodes = {0};
    model.defaultScene = 0;
    return model;
}

}  // namespace

GltfDocument build_gltf(const Scene& scene, const ExportConfig& config, const EncodedTexture* texture,
                        const GltfNames& names) {
    GltfDocument out;
    const bool embedded = names.texture_name.empty();
    const tinygltf::Model model = build_model(scene, config, texture, embedded, out.buffer);
    std::stringstream stream;
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, stream, false, false)) {
        throw std::logic_error("tinygltf did not serialise the scene");
    }
    // tinygltf's stream writer can only embed buffers and images as base64, copies them several times on the
    // way, and cuts integers of extras to 32 bits: so these are put in here.
    auto json = nlohmann::ordered_json::parse(stream.str());
    nlohmann::ordered_json buffer = {{"byteLength", out.buffer.size()}};
    if (!names.buffer_name.empty()) buffer["uri"] = percent_encoded(names.buffer_name);
    json["buffers"] = nlohmann::ordered_json::array({buffer});
    if (texture && !embedded) {
        json["images"][0] = {{"name", "texture"}, {"uri", percent_encoded(names.texture_name)}};
    }
    if (!scene.extras_json.empty()) {
        auto extras = nlohmann::ordered_json::parse(scene.extras_json, nullptr, false);
        if (!extras.is_object()) throw std::logic_error("the scene's extras are not a JSON object");
        json["asset"]["extras"] = std::move(extras);
    }
    constexpr auto kReplace =
        nlohmann::ordered_json::error_handler_t::replace;  // paths in extras may be no UTF-8
    out.json = json.dump(names.buffer_name.empty() ? -1 : 2, ' ', false, kReplace);
    return out;
}

}  // namespace hexrelief
