// What a mesh file holds, read from the file alone.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/data/geometry.h"

namespace hexrelief {

struct LevelDescription {
    long long vertices = 0, triangles = 0;
};

struct MeshDescription {
    std::string format;       // the extension without its dot
    long long vertices = 0;   // all meshes of the file together, but for coarser levels of detail; of .stl,
                              // which has none, the different corners
    long long triangles = 0;  // polygons counted as the triangles that they split into
    std::vector<LevelDescription> coarser;  // levels of detail of MSFT_lod, fine to coarse
    bool normals = false;
    bool texcoords = false;
    bool colors = false;
    std::string compression = "none";  // of the geometry, as export.compression names it
    std::vector<std::pair<std::string, long long>>
        geometry_bytes;  // "POSITION" .. "indices", or "Draco" for all in one
    long long texture_bytes =
        0;  // of the encoded images, inside or beside the file; those that are missing count 0
    bool has_bounds = false;  // min, max: of the positions, in glTF as the default scene places them
    Vec3f min, max;
    std::string generator;  // asset.generator, or the first comment; may be empty
};

}  // namespace hexrelief
