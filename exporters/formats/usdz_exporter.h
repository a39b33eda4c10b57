// Exports USDZ, which phones show: a USD text file and its texture in an uncompressed zip archive.
#pragma once

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

// Writes the texture as JPEG or PNG; JPEG if WebP is configured, which USDZ does not know.
void write_usdz(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files);

}  // namespace hexrelief::exporters
