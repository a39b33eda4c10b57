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

// From "NAME=DIR". Throws Error: usage where a part is missing, input where there is no such folder.
Peer peer_of(const std::string& text);

// The peer's meshes of a map, sorted by name: FOLDER/MAP.obj and FOLDER/MAP_*.obj. None = empty.
std::vector<std::filesystem::path> peer_files(const Peer& peer, const std::string& map);

// Vertices are x, y and disparity in px; the centre of the image's first pixel is (0.5, 0.5). Faces may have
// any number of corners, texture coordinates and normals, which are left out. Vertices that no face uses are
// dropped. Throws Error(input) naming file and line.
SurfaceMesh read_peer_mesh(const std::filesystem::path& path);

}  // namespace hexrelief::bench::rd
