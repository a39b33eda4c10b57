// The glTF document while it grows: what its geometry and its textures are added to.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "exporters/compression/draco_plan.h"
#include "exporters/formats/gltf/tinygltf.h"

namespace hexrelief::exporters {

// Where the bytes of a view of buffer 1 lie compressed in buffer 0.
struct MeshoptView {
    int view = 0;
    std::size_t offset = 0, bytes = 0;
    std::size_t count = 0, stride = 0;  // of what they decode to
    const char* mode = "ATTRIBUTES";
    bool octahedral = false;
};

struct GltfParts {
    tinygltf::Model model;
    std::vector<std::uint8_t> buffer;  // buffer 0
    std::size_t fallback_bytes = 0;  // of buffer 1, which meshopt's decoder fills and no file holds; 0 = none
    std::vector<MeshoptView> meshopt_views;  // apart, because tinygltf does not write a view's extensions
};

// One mesh of the document.
struct GltfGeometry {
    tinygltf::Primitive primitive;
    FileTransform transform;
    // Texture coordinates in the file times this are those of the texture.
    std::array<double, 2> texcoord_scale = {1, 1};
};

// Notes a used extension, once; `required`: a reader without it must refuse the file.
void use_extension(GltfParts& parts, const std::string& name, bool required);

// Appends to the buffer at a multiple of 4, as accessors need it, and returns the view's index.
int add_view(GltfParts& parts, const void* data, std::size_t bytes, int target, const char* name);
// view = -1: the data come from an extension.
int add_accessor(GltfParts& parts, int view, int component_type, int type, long long count, const char* name);
void set_bounds(tinygltf::Accessor& accessor, const Vec3f& low, const Vec3f& high);

inline constexpr int kNoTarget = 0;

// 65535 itself is the primitive restart value, so a short index may be at most 65534.
inline bool short_indices(long long vertices) {
    return vertices < 65535;
}
inline int index_type(long long vertices) {
    return short_indices(vertices) ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                   : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// The ways to hold a mesh. All attributes that it has are added.
GltfGeometry add_plain(GltfParts& parts, const TexturedMesh& textured);
GltfGeometry add_draco(GltfParts& parts, const TexturedMesh& textured, const Calibration* camera,
                       const ExportConfig& config, int threads);
// KHR_mesh_quantization; with meshopt also EXT_meshopt_compression.
GltfGeometry add_quantized(GltfParts& parts, const TexturedMesh& textured, const Calibration* camera,
                           const ExportConfig& config, bool meshopt);

// A camera that sees what the left image shows, but for its principal point, for which glTF has no member: it
// is in the camera's extras, with the focal length, in px. The camera's size is known, and the mesh lies in
// front of it. Returns the index of its node.
int add_camera(GltfParts& parts, const Calibration& camera, const SurfaceMesh& mesh);

}  // namespace hexrelief::exporters
