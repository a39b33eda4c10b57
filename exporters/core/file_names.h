// The names of formats and of the files that they consist of.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/scene.h"

namespace hexrelief::exporters {

// True if the format's levels of detail are separate files.
bool separate_levels(const std::filesystem::path& path, const ExportConfig& config);
// Returns the path of a level's file, "<stem>.lod<level><extension>", level >= 1.
std::filesystem::path level_path(const std::filesystem::path& path, int level);

enum class MeshFormat { glb, gltf, drc, obj, ply, stl, usdz, html };

// Returns the path's extension in lower case, with the dot.
std::string extension_of(const std::filesystem::path& path);

// Returns the formats' extensions, with the dot, in the enum's order: .glb .gltf .drc .obj
// .ply .stl .usdz .html
const std::vector<std::string>& export_extensions();

// Returns "glb", "gltf", "drc", "obj", "ply", "stl", "usdz" or "html".
std::string format_name(MeshFormat format);

// Chooses the format by the path's extension, in upper or lower case. Throws Error(usage), listing the
// extensions, if the extension is unknown, and if the name of an OBJ file has a line break: the file could
// not name its .mtl.
MeshFormat export_format(const std::filesystem::path& path);

}  // namespace hexrelief::exporters
