// The common signature of the format writers behind export_scene(). A writer puts its files into the
// transaction, `path` itself first, and throws Error(output). The scene has been checked, and config.normals
// is never `automatic` (see exporter.cpp).
#pragma once

#include <filesystem>

#include "exporters/core/file_transaction.h"
#include "exporters/core/scene.h"

namespace hexrelief::exporters {

using FormatWriter = void (*)(const Scene&, const ExportConfig&, const std::filesystem::path&,
                              FileTransaction&);

}  // namespace hexrelief::exporters
