// Exports binary STL, for printing and CAD: only triangles, in the unit export.stl_unit.
#pragma once

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

void write_stl(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files);

}  // namespace hexrelief::exporters
