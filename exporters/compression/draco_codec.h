// Draco compression, shared by .drc and glTF's KHR_draco_mesh_compression.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "exporters/compression/quantisation.h"
#include "exporters/core/scene.h"

namespace hexrelief::exporters {

// How finely attributes are kept. A grid, where there is one, replaces the mesh's values; it must have one
// step for all axes. Bits divide the widest side of the attribute's bounding box.
struct DracoQuantisation {
    std::optional<Grid<3>> positions;
    std::optional<Grid<2>> texcoords;
    // Draco keeps a grid's origin and range with six decimals, which small scenes need exactly.
    bool exact_boxes = false;
    int position_bits = 14;
    int normal_bits = 8;
    int texcoord_bits = 12;
    int level = 10;  // 0 (fast) .. 10 (small)
};

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

// Normals and texture coordinates that the mesh does not have are left out; those keep their origin at the
// top left. The bytes are the same for any number of threads. Throws Error(output) where libdraco refuses the
// mesh.
DracoMesh encode_draco(const SurfaceMesh& mesh, const DracoQuantisation& quantisation, int threads = 1);

// The values of a mesh whose triangles and attributes are known.
struct DracoValues {
    const SurfaceMesh* mesh;
    const DracoQuantisation* quantisation;
};

// The same where the values are still to be found, which goes on beside the encoding of the triangles. `mesh`
// has the triangles and the attributes, each with any values; level as that of the quantisation.
DracoMesh encode_draco(const SurfaceMesh& mesh, int level, const std::function<DracoValues()>& find,
                       int threads);

// The fewest bits with which Draco turns none of these unit vectors by more than tolerance_deg; at most 16.
// scale: of the axes in the file, by which normals have been multiplied before they were made unit vectors
// again.
int draco_normal_bits(const std::vector<Vec3f>& normals, const std::array<double, 3>& scale,
                      double tolerance_deg);

// What a Draco bitstream holds, for describe_mesh(). Throws Error(input) naming `name` where it is malformed.
struct DracoSummary {
    long long vertices = 0, triangles = 0;
    bool normals = false, texcoords = false, colors = false, has_bounds = false;
    Vec3f min, max;
};
DracoSummary summarise_draco(const std::vector<std::uint8_t>& bytes, const std::string& name);

}  // namespace hexrelief::exporters
