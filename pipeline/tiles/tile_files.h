// The files of a plan's lattices and solved tiles: little-endian numbers after a short header.
#pragma once

#include <filesystem>
#include <vector>

#include "mesher/tiles/lattice_tiles.h"
#include "mesher/tiles/tile_surface.h"

namespace hexrelief::tiles {

std::vector<std::uint8_t> lattice_bytes(const HexMesh2D& lattice);
std::vector<std::uint8_t> seam_bytes(const mesh_tiles::Seam& seam);
std::vector<std::uint8_t> tile_bytes(const mesh_tiles::TileMesh& mesh);

// Read a file. Throw Error(input) naming the file if it is missing, of another kind, damaged or truncated:
// sizes are checked before memory is allocated, corner numbers before they are used.
HexMesh2D read_lattice(const std::filesystem::path& path);
mesh_tiles::Seam read_seam(const std::filesystem::path& path);
mesh_tiles::TileMesh read_tile(const std::filesystem::path& path);

}  // namespace hexrelief::tiles
