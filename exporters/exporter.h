// Writes a surface mesh in the format of the file's extension.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/file_transaction.h"
#include "exporters/core/scene.h"
#include "exporters/mesh_formats.h"

namespace hexrelief::exporters {

// Writes the scene to `path` and returns all files written, `path` first (.gltf adds .bin and a texture, .obj
// adds .mtl and a texture, named after the path's stem; separate levels of detail follow, each with its own).
// Every file is written beside its target under a temporary name, and renamed when all are complete, so that
// a failure leaves nothing behind. The same scene and config give the same bytes. Throws Error(output) with
// the path and the system's reason.
std::vector<std::filesystem::path> export_scene(const Scene& scene, const ExportConfig& config,
                                                const std::filesystem::path& path);

// As export_scene() above, but the files are in place only when `files` is committed.
void export_scene(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
                  FileTransaction& files);

// Returns the configuration that the format of `path` leads to: whether normals are written, how positions
// are compressed, and their tolerance.
ExportConfig config_of_file(const Scene& scene, const ExportConfig& config,
                            const std::filesystem::path& path);

// Returns the number of bytes of all files that export_scene() would write, without leaving any
// file. Throws as export_scene().
std::uint64_t export_size(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path);

}  // namespace hexrelief::exporters
