// Exports glTF 2.0, binary (.glb, everything in one file) or split (.gltf + .bin + texture).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "exporters/core/scene.h"

namespace hexrelief::exporters {

// Returns a path as URLs have it: all but letters, digits and -_.~/ by their bytes.
std::string percent_encoded(std::string_view path);

// Returns a whole .glb file. path is for messages. Throws Error(output).
std::vector<std::uint8_t> glb_bytes(const Scene& scene, const ExportConfig& config,
                                    const std::filesystem::path& path);

}  // namespace hexrelief::exporters
