// What tolerances and bits mean for a mesh that Draco is to compress.
#pragma once

#include <array>

#include "exporters/compression/draco_codec.h"
#include "exporters/images/texture.h"

namespace hexrelief::exporters {

// The positions in space are translation + scale * the positions in the file, axis by axis.
struct FileTransform {
    std::array<double, 3> translation = {0, 0, 0}, scale = {1, 1, 1};
};

struct DracoPlan {
    SurfaceMesh mesh;  // as it goes into the file: its normals are those of the transformed positions
    DracoQuantisation quantisation;
    FileTransform transform;
};

// per_axis: positions in the file are cell numbers, counted from the camera, and need the transform. cubic:
// they are positions in space and need none. Bits that the configuration gives take precedence over
// tolerances, and then nothing is transformed.
DracoPlan plan_draco(const TexturedMesh& textured, const Calibration* camera, const ExportConfig& config,
                     GridShape shape, int threads = 1);

struct CompressedMesh {
    DracoMesh draco;
    FileTransform transform;
};

// Plans and encodes.
CompressedMesh compress_draco(const TexturedMesh& textured, const Calibration* camera,
                              const ExportConfig& config, GridShape shape, int threads);

// Normals of a surface whose positions have been divided by scale.
std::vector<Vec3f> scaled_normals(const std::vector<Vec3f>& normals, const std::array<double, 3>& scale);

}  // namespace hexrelief::exporters
