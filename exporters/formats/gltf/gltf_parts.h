// A glTF document under construction, to which geometry and textures are added.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "exporters/compression/draco_codec.h"
#include "exporters/formats/gltf/tinygltf.h"

namespace hexrelief::exporters {

// A view of buffer 1 whose compressed bytes lie in buffer 0.
struct MeshoptView {
    int view = 0;
    std::size_t offset = 0, bytes = 0;
    std::size_t count = 0, stride = 0;  // of the decoded data
    const char* mode = "ATTRIBUTES";
    bool octahedral = false;
};

struct GltfParts {
    tinygltf::Model model;
    std::vector<std::uint8_t> buffer;  // buffer 0
    // Size of buffer 1, which meshopt's decoder fills and no file holds; 0 = there is none.
    std::size_t fallback_bytes = 0;
    // Kept apart, because tinygltf does not write a view's extensions.
    std::vector<MeshoptView> meshopt_views;
};

// One mesh of the document.
struct GltfGeometry {
    tinygltf::Primitive primitive;
    FileTransform transform;
    // Scale from texture coordinates in the file to those of the texture.
    std::array<double, 2> texcoord_scale = {1, 1};
};

// Lists a used extension, once. `required`: a reader that does not know it must refuse the file.
void use_extension(GltfParts& parts, const std::string& name, bool required);

// Appends data to the buffer at a multiple of 4, as accessors need it, and returns the index of the new view.
int add_view(GltfParts& parts, const void* data, std::size_t bytes, int target, const char* name);
// Adds an accessor and returns its index. view = -1: an extension provides the data.
int add_accessor(GltfParts& parts, int view, int component_type, int type, long long count, const char* name);
void set_bounds(tinygltf::Accessor& accessor, const Vec3f& low, const Vec3f& high);

inline constexpr int kNoTarget = 0;

// True if 16-bit indices suffice. 65535 itself is the primitive restart value, so an index may
// be at most 65534.
inline bool short_indices(long long vertices) {
    return vertices < 65535;
}
inline int index_type(long long vertices) {
    return short_indices(vertices) ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                   : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// Says what the numbers of an accessor of _PROVENANCE mean, and how many vertices have each.
void describe_provenance(tinygltf::Accessor& accessor, const std::vector<Provenance>& provenance);
inline constexpr const char* kProvenance = "_PROVENANCE";

// Add a mesh, with all attributes that it has, as plain floats or compressed by Draco.
GltfGeometry add_plain(GltfParts& parts, const TexturedMesh& textured);
GltfGeometry add_draco(GltfParts& parts, const TexturedMesh& textured, const Calibration* camera,
                       const ExportConfig& config, int threads);
// Adds a mesh by KHR_mesh_quantization; with meshopt also EXT_meshopt_compression.
GltfGeometry add_quantized(GltfParts& parts, const TexturedMesh& textured, const Calibration* camera,
                           const ExportConfig& config, bool meshopt);

// Adds a camera that sees what the left image shows and returns the index of its node. glTF has no member for
// the principal point, so it is in the camera's extras, with the focal length, in px. Preconditions: the
// camera's image size is known, and the mesh lies in front of the camera.
int add_camera(GltfParts& parts, const Calibration& camera, const SurfaceMesh& mesh);

}  // namespace hexrelief::exporters
