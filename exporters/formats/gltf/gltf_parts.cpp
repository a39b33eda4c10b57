#include "exporters/formats/gltf/gltf_parts.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <span>

#include "exporters/compression/quantized_streams.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers begin with their last byte");

// Returns the number next to a texture coordinate in 0..1 that ends with a provenance: at most 2^-16 from it.
float ending_with(float coordinate, Provenance provenance) {
    constexpr std::uint32_t kBytes = 0x100, kLessThanHalf = 0x7f;
    const auto last = static_cast<std::uint32_t>(provenance);
    std::uint32_t bits =
        (std::bit_cast<std::uint32_t>(coordinate) + kLessThanHalf - last) / kBytes * kBytes + last;
    if (bits > std::bit_cast<std::uint32_t>(1.0f)) bits -= kBytes;
    return std::bit_cast<float>(bits);
}

// A byte a vertex that takes no room. Attributes lie at multiples of four, where numbers begin with their
// last byte: so it ends the second texture coordinate, by at most .06 px of 4096, and its accessor refers
// there. Bytes of its own would make files with both views 8 % larger. With a sparse accessor CesiumJS 1.140
// shows nothing of a mesh.
void add_provenance(GltfParts& parts, const std::vector<Provenance>& provenance, int texcoords_view,
                    tinygltf::Primitive& primitive) {
    constexpr const char* kName = "provenance";
    constexpr std::size_t kStride = 4;
    int view = texcoords_view;
    if (view < 0) {
        std::vector<std::uint8_t> bytes(provenance.size() * kStride);
        for (std::size_t i = 0; i < provenance.size(); ++i)
            bytes[i * kStride] = static_cast<std::uint8_t>(provenance[i]);
        view = add_view(parts, bytes.data(), bytes.size(), TINYGLTF_TARGET_ARRAY_BUFFER, kName);
    }
    parts.model.bufferViews[view].byteStride = texcoords_view < 0 ? kStride : sizeof(Vec2f);
    primitive.attributes[kProvenance] =
        add_accessor(parts, view, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_SCALAR,
                     static_cast<long long>(provenance.size()), kName);
    tinygltf::Accessor& accessor = parts.model.accessors.back();
    if (texcoords_view >= 0) accessor.byteOffset = offsetof(Vec2f, y);
    describe_provenance(accessor, provenance);
}

constexpr const char* kExtension = "KHR_draco_mesh_compression";

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr const char* kQuantization = "KHR_mesh_quantization";

// The encoding by meshoptimizer of `count` items of `size` bytes.
struct Compressed {
    std::vector<std::uint8_t> bytes;
    std::size_t count, size;
    const char* mode;  // the extension's word for the kind of items
    bool octahedral = false;
};

// Adds a view of buffer 1, which only exists once decoded, and notes where its compressed bytes lie.
int add_compressed_view(GltfParts& parts, const Compressed& compressed, int target, const char* name) {
    const auto& [bytes, count, size, mode, octahedral] = compressed;
    if (bytes.empty())
        throw Error(ErrorKind::output, std::string("cannot compress the mesh's ") + name +
                                           " with meshoptimizer; choose another export.compression");
    const int view = add_view(parts, bytes.data(), bytes.size(), target, name);
    tinygltf::BufferView& decoded = parts.model.bufferViews[view];
    parts.meshopt_views.push_back({view, decoded.byteOffset, bytes.size(), count, size, mode, octahedral});
    parts.fallback_bytes = (parts.fallback_bytes + 3) / 4 * 4;
    decoded.buffer = 1;
    decoded.byteOffset = parts.fallback_bytes;
    decoded.byteLength = count * size;
    parts.fallback_bytes += count * size;
    return view;
}

int add_stream_view(GltfParts& parts, const VertexStream& stream, const char* name, bool meshopt) {
    int view;
    if (meshopt) {
        std::vector<std::uint8_t> bytes(meshopt_encodeVertexBufferBound(stream.count, stream.stride));
        meshopt_encodeVertexVersion(0);  // required by the extension
        bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), stream.bytes.data(), stream.count,
                                                stream.stride));
        view = add_compressed_view(
            parts, {std::move(bytes), stream.count, stream.stride, "ATTRIBUTES", stream.octahedral},
            TINYGLTF_TARGET_ARRAY_BUFFER, name);
    } else {
        view = add_view(parts, stream.bytes.data(), stream.bytes.size(), TINYGLTF_TARGET_ARRAY_BUFFER, name);
    }
    parts.model.bufferViews[view].byteStride = stream.stride;
    return view;
}

// Adds the corners of triangles. Returns their accessor.
int add_indices(GltfParts& parts, std::span<const std::uint32_t> indices, long long vertices, bool meshopt) {
    const bool is_short = short_indices(vertices);
    const auto add = [&](const void* data, std::size_t bytes) {
        return add_view(parts, data, bytes, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, "indices");
    };
    int view;
    if (meshopt) {
        std::vector<std::uint8_t> bytes(
            meshopt_encodeIndexBufferBound(indices.size(), static_cast<std::size_t>(vertices)));
        meshopt_encodeIndexVersion(1);  // required by the extension
        bytes.resize(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size()));
        const std::size_t size = is_short ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
        view = add_compressed_view(parts, {std::move(bytes), indices.size(), size, "TRIANGLES"},
                                   TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, "indices");
    } else if (is_short) {
        const std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
        view = add(narrow.data(), narrow.size() * sizeof(narrow[0]));
    } else {
        view = add(indices.data(), indices.size_bytes());
    }
    return add_accessor(parts, view, index_type(vertices), TINYGLTF_TYPE_SCALAR,
                        static_cast<long long>(indices.size()), "indices");
}

}  // namespace

void use_extension(GltfParts& parts, const std::string& name, bool required) {
    const auto add = [&](std::vector<std::string>& names) {
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    };
    add(parts.model.extensionsUsed);
    if (required) add(parts.model.extensionsRequired);
}

int add_view(GltfParts& parts, const void* data, std::size_t bytes, int target, const char* name) {
    parts.buffer.resize((parts.buffer.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = parts.buffer.size();
    view.byteLength = bytes;
    view.target = target;
    view.name = name;
    const auto* begin = static_cast<const std::uint8_t*>(data);
    parts.buffer.insert(parts.buffer.end(), begin, begin + bytes);
    parts.model.bufferViews.push_back(view);
    return static_cast<int>(parts.model.bufferViews.size()) - 1;
}

int add_accessor(GltfParts& parts, int view, int component_type, int type, long long count,
                 const char* name) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = static_cast<std::size_t>(count);
    accessor.name = name;
    parts.model.accessors.push_back(accessor);
    return static_cast<int>(parts.model.accessors.size()) - 1;
}

void set_bounds(tinygltf::Accessor& accessor, const Vec3f& low, const Vec3f& high) {
    accessor.minValues = {low.x, low.y, low.z};
    accessor.maxValues = {high.x, high.y, high.z};
}

void describe_provenance(tinygltf::Accessor& accessor, const std::vector<Provenance>& provenance) {
    tinygltf::Value::Object extras;
    for (std::size_t k = 0; k < kProvenanceNames.size(); ++k) {
        const auto kind = static_cast<Provenance>(k);
        const auto vertices = static_cast<int>(std::ranges::count(provenance, kind));
        if (vertices > 0 || kind != Provenance::filled)
            extras[kProvenanceNames[k]] = tinygltf::Value(vertices);
    }
    accessor.extras = tinygltf::Value(std::move(extras));
}

int add_camera(GltfParts& parts, const Calibration& camera, const SurfaceMesh& mesh) {
    using tinygltf::Value;
    tinygltf::Camera& out = parts.model.cameras.emplace_back();
    out.name = "left";
    out.type = "perspective";
    out.perspective.yfov = 2 * std::atan(0.5 * camera.height / camera.focal_px);
    out.perspective.aspectRatio = static_cast<double>(camera.width) / camera.height;
    // Wide enough for a viewer that moves about: ten times nearer and a hundred times farther.
    const Bounds bounds = bounds_of(mesh.positions);
    out.perspective.znear = 0.1 * -static_cast<double>(bounds.high.z);
    out.perspective.zfar = 100 * -static_cast<double>(bounds.low.z);
    out.extras =
        Value(Value::Object{{"focal_px", Value(camera.focal_px)},
                            {"principal_point_px", Value(Value::Array{Value(camera.cx), Value(camera.cy)})},
                            {"size_px", Value(Value::Array{Value(camera.width), Value(camera.height)})}});
    // Vertices are in the camera's frame, which is glTF's: the node needs no transform.
    tinygltf::Node& node = parts.model.nodes.emplace_back();
    node.name = "left camera";
    node.camera = static_cast<int>(parts.model.cameras.size()) - 1;
    return static_cast<int>(parts.model.nodes.size()) - 1;
}

GltfGeometry add_plain(GltfParts& parts, const TexturedMesh& textured) {
    const SurfaceMesh& mesh = textured.mesh;
    const auto vertices = static_cast<long long>(mesh.positions.size());
    GltfGeometry out;
    const auto add = [&](const char* attribute, const auto& values, int type, const char* name) {
        const int view = add_view(parts, values.data(), values.size() * sizeof(values[0]),
                                  TINYGLTF_TARGET_ARRAY_BUFFER, name);
        out.primitive.attributes[attribute] =
            add_accessor(parts, view, TINYGLTF_COMPONENT_TYPE_FLOAT, type, vertices, name);
    };
    add("POSITION", mesh.positions, TINYGLTF_TYPE_VEC3, "positions");
    const Bounds bounds = bounds_of(mesh.positions);
    set_bounds(parts.model.accessors.back(), bounds.low, bounds.high);
    if (!mesh.normals.empty()) add("NORMAL", mesh.normals, TINYGLTF_TYPE_VEC3, "normals");
    int texcoords_view = -1;
    if (!mesh.texcoords.empty()) {
        std::vector<Vec2f> texcoords = mesh.texcoords;
        for (std::size_t i = 0; i < mesh.provenance.size(); ++i)
            texcoords[i].y = ending_with(texcoords[i].y, mesh.provenance[i]);
        add("TEXCOORD_0", texcoords, TINYGLTF_TYPE_VEC2, "texcoords");
        texcoords_view = parts.model.accessors.back().bufferView;
    }
    const auto* const corners = reinterpret_cast<const std::uint32_t*>(mesh.triangles.data());
    out.primitive.indices = add_indices(parts, {corners, 3 * mesh.triangles.size()}, vertices, false);
    if (!mesh.provenance.empty()) add_provenance(parts, mesh.provenance, texcoords_view, out.primitive);
    return out;
}

// The accessors describe what a decoder returns and have no buffer view: there is no uncompressed fallback,
// so the extension is required.
GltfGeometry add_draco(GltfParts& parts, const TexturedMesh& textured, const Calibration* camera,
                       const ExportConfig& config, int threads) {
    const auto [compressed, transform] =
        compress_draco(textured, camera, config, GridShape::per_axis, threads);
    const DracoMesh& draco = compressed;  // clang 14 does not let a lambda capture a structured binding
    GltfGeometry out;
    out.transform = transform;
    tinygltf::Value::Object ids;
    const auto add = [&](const char* attribute, int id, int type, const char* name) {
        if (id < 0) return;
        ids[attribute] = tinygltf::Value(id);
        out.primitive.attributes[attribute] =
            add_accessor(parts, -1, TINYGLTF_COMPONENT_TYPE_FLOAT, type, draco.vertices, name);
    };
    add("POSITION", draco.position_id, TINYGLTF_TYPE_VEC3, "positions");
    set_bounds(parts.model.accessors.back(), draco.min, draco.max);
    add("NORMAL", draco.normal_id, TINYGLTF_TYPE_VEC3, "normals");
    add("TEXCOORD_0", draco.texcoord_id, TINYGLTF_TYPE_VEC2, "texcoords");
    out.primitive.indices = add_accessor(parts, -1, index_type(draco.vertices), TINYGLTF_TYPE_SCALAR,
                                         draco.triangles * 3, "indices");
    const int view = add_view(parts, draco.bytes.data(), draco.bytes.size(), kNoTarget, "draco");
    out.primitive.extensions[kExtension] = tinygltf::Value(tinygltf::Value::Object{
        {"bufferView", tinygltf::Value(view)}, {"attributes", tinygltf::Value(std::move(ids))}});
    use_extension(parts, kExtension, true);
    return out;
}

GltfGeometry add_quantized(GltfParts& parts, const TexturedMesh& textured, const Calibration* camera,
                           const ExportConfig& config, bool meshopt) {
    const QuantizedMesh mesh = quantize_mesh(textured, camera, config, meshopt);
    GltfGeometry out;
    out.transform = mesh.transform;
    out.texcoord_scale = mesh.texcoord_scale;
    const auto add = [&](const char* attribute, const VertexStream& stream, const char* name) {
        if (stream.count == 0) return;
        const int view = add_stream_view(parts, stream, name, meshopt);
        const int index = add_accessor(parts, view, static_cast<int>(stream.type),
                                       stream.components == 1   ? TINYGLTF_TYPE_SCALAR
                                       : stream.components == 2 ? TINYGLTF_TYPE_VEC2
                                                                : TINYGLTF_TYPE_VEC3,
                                       static_cast<long long>(stream.count), name);
        parts.model.accessors[index].normalized = stream.normalized;
        parts.model.accessors[index].minValues = stream.low;
        parts.model.accessors[index].maxValues = stream.high;
        out.primitive.attributes[attribute] = index;
    };
    add("POSITION", mesh.positions, "positions");
    add("NORMAL", mesh.normals, "normals");
    add("TEXCOORD_0", mesh.texcoords, "texcoords");
    if (mesh.provenance.count > 0) {
        add(kProvenance, mesh.provenance, "provenance");
        describe_provenance(parts.model.accessors.back(), textured.mesh.provenance);
    }
    out.primitive.indices =
        add_indices(parts, mesh.indices, static_cast<long long>(mesh.positions.count), meshopt);
    use_extension(parts, kQuantization, true);
    if (meshopt) use_extension(parts, kMeshopt, true);
    return out;
}

}  // namespace hexrelief::exporters
