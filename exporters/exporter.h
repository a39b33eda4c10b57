// Writes a surface mesh; the file's extension chooses the format.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

struct DracoConfig {
    bool enabled = false;    // compress .glb and .gltf with KHR_draco_mesh_compression; .drc always is
    int position_bits = 12;  // 1..30
    int normal_bits = 8;     // 2..30
    int texcoord_bits = 12;  // 1..30
    int level = 7;           // 0 (fast) .. 10 (small)
};

enum class TextureFormat { jpeg, png };

struct ExportConfig {
    DracoConfig draco;
    TextureFormat texture_format = TextureFormat::jpeg;
    int jpeg_quality = 90;  // 1..100
};

// What is written. texture may be null: then no image and no texture coordinates are written.
struct Scene {
    const SurfaceMesh* mesh = nullptr;
    const Image* texture = nullptr;
    std::string generator;    // asset.generator and file comments: "hexrelief 0.1.0"
    std::string extras_json;  // a JSON object for glTF's asset.extras: the effective parameters; may be empty
};

// The formats' extensions, with the dot: .glb .gltf .drc .obj .ply
const std::vector<std::string>& export_extensions();

// "glb", "gltf", "drc", "obj", "ply" for a path whose extension (any case) is one of those.
// Throws Error(usage) listing the extensions otherwise.
std::string export_format(const std::filesystem::path& path);

// Writes scene to path and returns all files written, path first (.gltf adds .bin and a texture, .obj adds
// .mtl and a texture, named after path's stem). Every file is written beside its target under a temporary
// name and renamed when all are complete, so that a failure leaves nothing behind. Throws Error(output) with
// path and the system's reason; the same scene and config give the same bytes.
std::vector<std::filesystem::path> export_scene(const Scene& scene, const ExportConfig& config,
                                                const std::filesystem::path& path);

}  // namespace hexrelief
