// Writes a surface mesh in the format of the file's extension.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/file_transaction.h"
#include "exporters/core/mesh_format.h"
#include "exporters/core/scene.h"
#include "exporters/inspect/describe_mesh.h"

namespace hexrelief::exporters {

// Returns all formats in the order in which help and documents list them.
const std::vector<const MeshFormat*>& mesh_formats();

// Returns the extensions of all formats: ".glb .gltf ...".
std::string export_extensions();

// Returns the format of the path's extension, in upper or lower case; null for an unknown extension.
const MeshFormat* find_mesh_format(const std::filesystem::path& path);

// Returns the format of the path's extension. Throws Error(usage), which lists the extensions, for an unknown
// one; and Error(usage) for a path with a line break if the format could not name its companion files.
const MeshFormat& export_format(const std::filesystem::path& path);

// Describes the contents of a mesh file. Reads .ply in ASCII and binary of either byte order, .stl in binary,
// .usdz of text, and all of .glb except its buffer. Never allocates more than a small multiple of the file's
// size (for .drc: than its decoder allocates). Throws Error(usage) for an unknown extension, Error(input) for
// a file that is missing, empty, above 2 GiB (for .glb: not counting its buffer), truncated or malformed.
inspect::MeshDescription describe_mesh(const std::filesystem::path& path);

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
