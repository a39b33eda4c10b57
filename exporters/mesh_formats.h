// All mesh formats, by the extension of a file's name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/mesh_format.h"
#include "exporters/inspect/describe_mesh.h"

namespace hexrelief::exporters {

// In the order in which users are told of them.
const std::vector<const MeshFormat*>& mesh_formats();

// ".glb .gltf ...": the extensions of all.
std::string export_extensions();

// By the path's extension, in any case; null for another one.
const MeshFormat* find_mesh_format(const std::filesystem::path& path);

// Throws Error(usage) that lists the extensions for another one, and for a path with a line break if the
// format could not name the files beside it.
const MeshFormat& export_format(const std::filesystem::path& path);

// What a mesh file holds. Reads .ply in ASCII and binary of either byte order, .stl in binary, .usdz of text,
// and of .glb all but its buffer. Never allocates more than a small multiple of the file's size (.drc: than
// its decoder). Throws Error(usage) for another extension, Error(input) for a file that is missing, empty,
// above 2 GiB (.glb: but for its buffer), truncated or malformed.
inspect::MeshDescription describe_mesh(const std::filesystem::path& path);

}  // namespace hexrelief::exporters
