// The formats behind export_scene(): one signature for all. Each puts its files into the transaction, path
// itself first, and throws Error(output); the scene has been checked, and the
// normals are always or never written (see exporter.cpp).
#pragma once

#include <filesystem>

#include "exporters/core/file_transaction.h"
#include "exporters/core/scene.h"

namespace hexrelief::exporters {

using FormatWriter = void (*)(const Scene&, const ExportConfig&, const std::filesystem::path&,
                              FileTransaction&);

}  // namespace hexrelief::exporters
