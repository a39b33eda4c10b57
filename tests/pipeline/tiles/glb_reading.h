// Reads the mesh of a GLB as any reader has to interpret it, in double arithmetic.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "pipeline/data/hex_mesh.h"

namespace hexrelief::tiles {

struct SpaceMesh {
    std::vector<std::array<double, 3>> positions;  // the node's transform applied
    std::vector<Triangle> triangles;
};

// Reads files without compression, quantized, by meshopt or by Draco; of one node or of
// many, which are joined.
SpaceMesh read_glb(const std::filesystem::path& path);

}  // namespace hexrelief::tiles
