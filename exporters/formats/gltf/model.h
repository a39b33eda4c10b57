// Builds the glTF document of a scene: its JSON and its one binary buffer, for both containers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "exporters/core/scene.h"
#include "exporters/images/texture.h"

namespace hexrelief::exporters {

struct GltfDocument {
    std::string json;
    std::vector<std::uint8_t> buffer;
    EncodedTexture texture;  // contents of the file names.texture_name; empty = no such file
};

// Names of the files that the document refers to; empty = in the buffer
// (.glb). build_gltf() percent-encodes them.
struct GltfNames {
    std::string buffer_name;
    std::string texture_name;
};

GltfDocument build_gltf(const Scene& scene, const ExportConfig& config, const GltfNames& names);

}  // namespace hexrelief::exporters
