// USDZ: a USD text file and its texture in an uncompressed zip, as phones show it.
#pragma once

#include "exporters/core/format_writer.h"

namespace hexrelief::exporters {

// The texture is JPEG or PNG; one configured as WebP, which USDZ does not know, is written as JPEG.
void write_usdz(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                FileTransaction& files);

}  // namespace hexrelief::exporters
