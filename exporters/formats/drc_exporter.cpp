#include "exporters/formats/drc_exporter.h"

#include "exporters/compression/draco_plan.h"

namespace hexrelief::exporters {

void write_drc(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    const TexturedMesh mesh = untextured_mesh(scene, config);
    files.write(path,
                compress_draco(mesh, scene.camera, config, GridShape::cubic, scene.threads).draco.bytes);
}

}  // namespace hexrelief::exporters
