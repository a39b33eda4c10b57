// Adds meshes as floats and plain indices, which every glTF reader knows.
#include "exporters/formats/gltf/gltf_parts.h"
#include "pipeline/data/bounds.h"

namespace hexrelief::exporters {
namespace {

// One byte in four, because attributes lie at multiples of four. With a sparse accessor files would be 7 %
// shorter, but CesiumJS 1.140 shows nothing of a mesh that has one.
void add_provenance(GltfParts& parts, const std::vector<Provenance>& provenance,
                    tinygltf::Primitive& primitive) {
    constexpr const char* kName = "provenance";
    constexpr std::size_t kStride = 4;
    std::vector<std::uint8_t> bytes(provenance.size() * kStride);
    for (std::size_t i = 0; i < provenance.size(); ++i)
        bytes[i * kStride] = static_cast<std::uint8_t>(provenance[i]);
    const int view = add_view(parts, bytes.data(), bytes.size(), TINYGLTF_TARGET_ARRAY_BUFFER, kName);
    parts.model.bufferViews[view].byteStride = kStride;
    primitive.attributes[kProvenance] =
        add_accessor(parts, view, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_SCALAR,
                     static_cast<long long>(provenance.size()), kName);
    describe_provenance(parts.model.accessors.back(), provenance);
}

}  // namespace

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
    if (!mesh.texcoords.empty()) add("TEXCOORD_0", mesh.texcoords, TINYGLTF_TYPE_VEC2, "texcoords");

    int view;
    if (short_indices(vertices)) {
        std::vector<std::uint16_t> indices;
        indices.reserve(mesh.triangles.size() * 3);
        for (const Triangle& t : mesh.triangles) {
            for (const std::uint32_t i : t) indices.push_back(static_cast<std::uint16_t>(i));
        }
        view = add_view(parts, indices.data(), indices.size() * sizeof(indices[0]),
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, "indices");
    } else {
        view = add_view(parts, mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle),
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, "indices");
    }
    out.primitive.indices = add_accessor(parts, view, index_type(vertices), TINYGLTF_TYPE_SCALAR,
                                         static_cast<long long>(mesh.triangles.size()) * 3, "indices");
    if (!mesh.provenance.empty()) add_provenance(parts, mesh.provenance, out.primitive);
    return out;
}

}  // namespace hexrelief::exporters
