#include "exporters/formats/drc_exporter.h"

#include "exporters/compression/draco_plan.h"

namespace hexrelief {

void write_drc(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    const DracoPlan plan =
        plan_draco(untextured_mesh(scene, config), scene.camera, config, GridShape::cubic, scene.threads);
    files.write(path, encode_draco(plan.mesh, plan.quantisation, scene.threads).bytes);
}

}  // namespace hexrelief
