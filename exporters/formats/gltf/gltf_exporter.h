// glTF 2.0, binary (.glb, everything in one file) and split (.gltf + .bin + texture).
#pragma once

#include <cstdint>
#include <vector>

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

void write_glb(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files);
void write_gltf(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files);

// The file that write_glb() writes. path names it in messages. Throws Error(output).
std::vector<std::uint8_t> glb_bytes(const Scene& scene, const ExportConfig& config,
                                    const std::filesystem::path& path);

}  // namespace hexrelief::exporters
