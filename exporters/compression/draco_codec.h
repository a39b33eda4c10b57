// Draco compression, shared by .drc files and glTF's KHR_draco_mesh_compression, and the box of a grid in
// Draco's own quantisation.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "exporters/compression/quantisation.h"
#include "exporters/core/scene.h"
#include "exporters/images/texture.h"

namespace hexrelief::exporters {

// The precision of a mesh's attributes. If a grid is given, it replaces the mesh's values; its step must be
// the same on all axes. Otherwise the bits divide the widest side of the attribute's bounding box.
struct DracoQuantisation {
    std::optional<Grid<3>> positions;
    std::optional<Grid<2>> texcoords;
    // If false, a grid's origin and range are rounded to six decimals, as Draco does by default; small
    // scenes need exact values.
    bool exact_boxes = false;
    int position_bits = 14;
    int normal_bits = 8;
    int texcoord_bits = 12;
    int level = 10;  // 0 (fast) .. 10 (small)
};

// A compressed mesh, described as a decoder will return it: it may split a vertex where the surface touches
// itself, and drops triangles that use a vertex twice.
struct DracoMesh {
    std::vector<std::uint8_t> bytes;
    long long vertices = 0;
    long long triangles = 0;
    Vec3f min, max;        // exact bounds of the decoded positions
    int position_id = -1;  // the attributes' unique ids; -1 = attribute is missing
    int normal_id = -1;
    int texcoord_id = -1;
};

// The attribute values of a mesh and their quantisation.
struct DracoValues {
    const SurfaceMesh* mesh;
    const DracoQuantisation* quantisation;
};

// Compresses a mesh whose values are not known yet: find() is called while the triangles are being encoded.
// `mesh` has the triangles and the attributes, with arbitrary values; `level` must be the level of the
// quantisation that find() returns. Normals and texture coordinates that the mesh does not have are left out;
// texture coordinates keep their origin at the top left. The bytes are the same for any number of threads.
// Throws Error(output) if libdraco refuses the mesh.
DracoMesh encode_draco(const SurfaceMesh& mesh, int level, const std::function<DracoValues()>& find,
                       int threads);

// Returns the fewest bits with which Draco turns none of these unit vectors by more than tolerance_deg;
// at most 16. `scale` holds the scale of the file's axes, by which the normals were multiplied before
// they were normalised again.
int draco_normal_bits(const std::vector<Vec3f>& normals, const std::array<double, 3>& scale,
                      double tolerance_deg);

// The contents of a Draco bitstream, for describe_mesh().
struct DracoSummary {
    long long vertices = 0, triangles = 0;
    bool normals = false, texcoords = false, colors = false, has_bounds = false;
    Vec3f min, max;
};
// Summarises a bitstream. Throws Error(input) naming `name` if it is malformed.
DracoSummary summarise_draco(const std::vector<std::uint8_t>& bytes, const std::string& name);

// The transform from the file to space, axis by axis: position in space = translation + scale *
// position in the file.
struct FileTransform {
    std::array<double, 3> translation = {0, 0, 0}, scale = {1, 1, 1};
};

struct DracoPlan {
    SurfaceMesh mesh;  // as it goes into the file: normals are those of the transformed positions
    DracoQuantisation quantisation;
    FileTransform transform;
};

// Plans the compression of a mesh. per_axis: positions in the file are cell numbers, counted from the camera,
// and need the transform. cubic: positions in the file are positions in space. If the configuration gives
// bits, these take precedence over tolerances, and nothing is transformed.
DracoPlan plan_draco(const TexturedMesh& textured, const Calibration* camera, const ExportConfig& config,
                     GridShape shape, int threads = 1);

struct CompressedMesh {
    DracoMesh draco;
    FileTransform transform;
};

// Plans and encodes a mesh.
CompressedMesh compress_draco(const TexturedMesh& textured, const Calibration* camera,
                              const ExportConfig& config, GridShape shape, int threads);

// Returns the normals of a surface whose positions have been divided by `scale`.
std::vector<Vec3f> scaled_normals(const std::vector<Vec3f>& normals, const std::array<double, 3>& scale);

}  // namespace hexrelief::exporters

namespace draco {
class ExpertEncoder;
}

namespace hexrelief::exporters {

// The box of a grid in Draco's own quantisation. A decoder returns origin + cell * range / (2^bits - 1),
// computed in floats.
struct DracoBox {
    int bits = 0;
    std::array<float, 3> origin = {};
    float range = 0;
};

// Returns the grid's box, exactly or with origin and range rounded to six decimals, as Draco
// writes them by itself.
template <int N>
DracoBox box_of(const Grid<N>& grid, bool exactly);

// Makes Draco quantise the attribute on the grid.
template <int N>
void set_box(draco::ExpertEncoder& encoder, int attribute, const Grid<N>& grid, bool exactly);

// Returns the largest error, in px, of the positions that a decoder will return; measured as by
// quantise_positions(): as seen by the camera, in x, in y and in disparity. Infinite or NaN if
// the box is invalid.
double position_error_px(const SurfaceMesh& mesh, const Calibration& camera, const Grid<3>& grid,
                         const FileTransform& transform, bool exactly);

// Returns the largest error of texture coordinates, in px of a texture of that size. Infinite if
// the box is invalid.
double texcoord_error_px(const std::vector<Vec2f>& texcoords, int width, int height, const Grid<2>& grid,
                         bool exactly);

}  // namespace hexrelief::exporters
