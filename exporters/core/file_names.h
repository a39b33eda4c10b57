// The formats' names and the names of the files that they consist of.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/scene.h"

namespace hexrelief {

// Whether a format's levels of detail are files of their own, and their paths:
// "<stem>.lod<level><extension>", level >= 1.
bool separate_levels(const std::filesystem::path& path, const ExportConfig& config);
std::filesystem::path level_path(const std::filesystem::path& path, int level);

enum class MeshFormat { glb, gltf, drc, obj, ply, stl, usdz, html };

// In lower case, with the dot.
std::string extension_of(const std::filesystem::path& path);

// The formats' extensions, with the dot, in the enum's order: .glb .gltf .drc .obj .ply .stl .usdz .html
const std::vector<std::string>& export_extensions();

// "glb", "gltf", "drc", "obj", "ply", "stl", "usdz", "html".
std::string format_name(MeshFormat format);

// By the path's extension, in any case. Throws Error(usage) listing the extensions for another one, and
// for an OBJ file whose name has a line break: it could not name its .mtl.
MeshFormat export_format(const std::filesystem::path& path);

// How files of a format hold positions: export.compression is of .glb and .gltf alone.
Compression compression_of(MeshFormat format, const ExportConfig& config);

}  // namespace hexrelief
