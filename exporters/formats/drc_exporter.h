// Exports a bare Draco bitstream: positions, normals, texture coordinates.
#pragma once

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

void write_drc(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files);

}  // namespace hexrelief::exporters
