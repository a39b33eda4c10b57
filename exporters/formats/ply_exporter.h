// Exports binary little-endian PLY, with vertex colours taken from the texture.
#pragma once

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

void write_ply(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files);

}  // namespace hexrelief::exporters
