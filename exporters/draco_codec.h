// Draco compression, shared by .drc and glTF's KHR_draco_mesh_compression.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "exporters/exporter.h"

namespace hexrelief {

// A compressed mesh and what a decoder makes of it. The counts are the decoder's: it may split a vertex where
// the surface touches itself, and drops triangles that use a vertex twice.
struct DracoMesh {
    std::vector<std::uint8_t> bytes;
    long long vertices = 0;
    long long triangles = 0;
    Vec3f min, max;        // of the decoded positions, exactly
    int position_id = -1;  // the attributes' unique ids; -1 = not there
    int normal_id = -1;
    int texcoord_id = -1;
};

// Texture coordinates keep their origin at the top left. Throws Error(output) where libdraco refuses the
// mesh.
DracoMesh encode_draco(const SurfaceMesh& mesh, bool with_texcoords, const DracoConfig& config);

// What a Draco bitstream holds, for describe_mesh(). Throws Error(input) naming `name` where it is malformed.
struct DracoSummary {
    long long vertices = 0, triangles = 0;
    bool normals = false, texcoords = false, colors = false, has_bounds = false;
    Vec3f min, max;
};
DracoSummary summarise_draco(const std::vector<std::uint8_t>& bytes, const std::string& name);

}  // namespace hexrelief
