// Meshes of other programs for `hexrelief bench rd`: OBJ files in disparity space.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/surface_mesh.h"

namespace hexrelief::bench::rd {

struct Peer {
    std::string name;
    std::filesystem::path folder;
};

// Parses "NAME=DIR". Throws Error(usage) if a part is missing, Error(input) if there is no such folder.
Peer peer_of(const std::string& text);

// Returns the peer's meshes of a map, sorted by name: FOLDER/MAP.obj and FOLDER/MAP_*.obj; may be empty.
std::vector<std::filesystem::path> peer_files(const Peer& peer, const std::string& map);

// Reads a mesh whose vertices are x, y and disparity in px; the centre of the image's first pixel is (0.5,
// 0.5). Faces may have any number of corners; texture coordinates and normals are ignored. Vertices that no
// face uses are dropped. Throws Error(input) naming file and line.
SurfaceMesh read_peer_mesh(const std::filesystem::path& path);

}  // namespace hexrelief::bench::rd
