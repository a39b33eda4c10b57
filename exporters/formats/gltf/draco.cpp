// Adds meshes by KHR_draco_mesh_compression.
#include "exporters/formats/gltf/gltf_parts.h"

namespace hexrelief::exporters {
namespace {

constexpr const char* kExtension = "KHR_draco_mesh_compression";

}  // namespace

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

}  // namespace hexrelief::exporters
