// Translates tolerances and bits into Draco's quantisation of a mesh.
#pragma once

#include <array>

#include "exporters/compression/draco_codec.h"
#include "exporters/images/texture.h"

namespace hexrelief::exporters {

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
