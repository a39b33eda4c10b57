// Adds meshes by KHR_mesh_quantization, and EXT_meshopt_compression on top of it.
#include <meshoptimizer.h>

#include <algorithm>

#include "exporters/compression/quantized_streams.h"
#include "exporters/formats/gltf/gltf_parts.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr const char* kQuantization = "KHR_mesh_quantization";

int gltf_component(ComponentType type) {
    switch (type) {
        case ComponentType::int8:
            return TINYGLTF_COMPONENT_TYPE_BYTE;
        case ComponentType::uint8:
            return TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
        case ComponentType::int16:
            return TINYGLTF_COMPONENT_TYPE_SHORT;
        case ComponentType::uint16:
            return TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
        case ComponentType::float32:
            break;
    }
    return TINYGLTF_COMPONENT_TYPE_FLOAT;
}

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

template <typename Index>
int add_index_view(GltfParts& parts, const std::vector<std::uint32_t>& indices, std::size_t vertices,
                   bool meshopt) {
    if (meshopt) {
        std::vector<std::uint8_t> bytes(meshopt_encodeIndexBufferBound(indices.size(), vertices));
        meshopt_encodeIndexVersion(1);  // required by the extension
        bytes.resize(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size()));
        return add_compressed_view(parts, {std::move(bytes), indices.size(), sizeof(Index), "TRIANGLES"},
                                   TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, "indices");
    }
    const std::vector<Index> narrow(indices.begin(), indices.end());
    return add_view(parts, narrow.data(), narrow.size() * sizeof(Index), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER,
                    "indices");
}

}  // namespace

GltfGeometry add_quantized(GltfParts& parts, const TexturedMesh& textured, const Calibration* camera,
                           const ExportConfig& config, bool meshopt) {
    const QuantizedMesh mesh = quantize_mesh(textured, camera, config, meshopt);
    GltfGeometry out;
    out.transform = mesh.transform;
    out.texcoord_scale = mesh.texcoord_scale;
    const auto add = [&](const char* attribute, const VertexStream& stream, const char* name) {
        if (stream.count == 0) return;
        const int view = add_stream_view(parts, stream, name, meshopt);
        const int index = add_accessor(parts, view, gltf_component(stream.type),
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
    const std::size_t vertices = mesh.positions.count;
    const bool narrow = short_indices(static_cast<long long>(vertices));
    const int view = narrow ? add_index_view<std::uint16_t>(parts, mesh.indices, vertices, meshopt)
                            : add_index_view<std::uint32_t>(parts, mesh.indices, vertices, meshopt);
    out.primitive.indices =
        add_accessor(parts, view, index_type(static_cast<long long>(vertices)), TINYGLTF_TYPE_SCALAR,
                     static_cast<long long>(mesh.indices.size()), "indices");
    use_extension(parts, kQuantization, true);
    if (meshopt) use_extension(parts, kMeshopt, true);
    return out;
}

}  // namespace hexrelief::exporters
