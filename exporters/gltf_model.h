// The glTF document of a scene: its JSON and its one binary buffer, for both containers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "exporters/exporter.h"
#include "exporters/texture.h"

namespace hexrelief {

struct GltfDocument {
    std::string json;
    std::vector<std::uint8_t> buffer;
};

// Names of the files that the document refers to; empty = in the buffer (.glb). Percent-encoded by the
// callee.
struct GltfNames {
    std::string buffer_name;
    std::string texture_name;
};

// texture is null where the scene has none. With names.texture_name its bytes are left out of the buffer.
GltfDocument build_gltf(const Scene& scene, const ExportConfig& config, const EncodedTexture* texture,
                        const GltfNames& names);

}  // namespace hexrelief
