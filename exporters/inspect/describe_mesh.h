// Describes the contents of a mesh file.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::inspect {

struct LevelDescription {
    long long vertices = 0, triangles = 0;
};

struct MeshDescription {
    std::string format;  // the extension without its dot
    // Sum over all meshes of the file, without coarser levels of detail; for .stl, which has no vertices, the
    // number of different corners.
    long long vertices = 0;
    long long triangles = 0;                // polygons count as the triangles that they split into
    std::vector<LevelDescription> coarser;  // levels of detail of MSFT_lod, fine to coarse
    bool normals = false;
    bool texcoords = false;
    bool colors = false;
    // Vertices by the cameras that saw them, as Provenance; all 0 = the file does not tell.
    std::array<long long, kProvenanceNames.size()> provenance = {};
    std::string compression = "none";  // of the geometry, in the terms of export.compression
    // "POSITION" .. "indices", or one entry "Draco"
    std::vector<std::pair<std::string, long long>> geometry_bytes;
    long long texture_bytes = 0;  // encoded images inside or beside the file; missing ones count 0
    bool has_bounds = false;  // min, max: bounds of the positions, in glTF as the default scene places them
    Vec3f min, max;
    std::string generator;  // asset.generator, or the first comment; may be empty
};

}  // namespace hexrelief::inspect
