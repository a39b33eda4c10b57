// Exports Wavefront OBJ with a material library and a texture file beside it.
#pragma once

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

void write_obj(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files);

}  // namespace hexrelief::exporters
