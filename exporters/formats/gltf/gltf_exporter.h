// Exports glTF 2.0, binary (.glb, everything in one file) or split (.gltf + .bin + texture).
#pragma once

#include <cstdint>
#include <vector>

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

void write_glb(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files);
void write_gltf(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files);

// Returns the bytes of the file that write_glb() writes. `path` names it in messages. Throws Error(output) if
// they are 4 GiB or more.
std::vector<std::uint8_t> glb_bytes(const Scene& scene, const ExportConfig& config,
                                    const std::filesystem::path& path);

}  // namespace hexrelief::exporters
