// All mesh formats, found by the extension of a file's name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/mesh_format.h"
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

}  // namespace hexrelief::exporters
