// Decodes Draco meshes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::inspect {

struct DracoGeometry {
    std::vector<Vec3f> positions;  // dequantised
    std::vector<Triangle> triangles;
};

// Decodes a mesh. Throws Error(input) naming `name` if the bytes are malformed or hold no mesh with
// positions of three components.
DracoGeometry decode_draco(const std::vector<std::uint8_t>& bytes, const std::string& name);

}  // namespace hexrelief::inspect
