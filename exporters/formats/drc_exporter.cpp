// A bare Draco bitstream: positions, normals, texture coordinates.
#include "exporters/compression/draco_codec.h"
#include "exporters/core/mesh_format.h"
#include "exporters/inspect/describe_formats.h"

namespace hexrelief::exporters {
namespace {

void write_drc(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    const SurfaceMesh left = left_view_of(*scene.mesh, scene.image_width, scene.image_height);
    Scene of_left = scene;
    of_left.mesh = &left;
    const TexturedMesh mesh = untextured_mesh(of_left, config);
    files.write(path,
                compress_draco(mesh, scene.camera, config, GridShape::cubic, scene.threads).draco.bytes);
}

}  // namespace

extern const MeshFormat drc_format = {
    .extension = ".drc",
    .holds = "Draco: positions, normals, texture coordinates of the whole left image; the left view only",
    .write = write_drc,
    .describe = inspect::describe_drc,
    .compression = Compression::draco,
};

}  // namespace hexrelief::exporters
