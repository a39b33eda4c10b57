#include "exporters/drc_exporter.h"

#include "exporters/draco_codec.h"

namespace hexrelief {

void write_drc(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path,
               FileTransaction& files) {
    files.write(path, encode_draco(*scene.mesh, scene.texture != nullptr, config.draco).bytes);
}

}  // namespace hexrelief
