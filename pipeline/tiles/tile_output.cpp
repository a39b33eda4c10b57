#include "pipeline/tiles/tile_output.h"

#include <algorithm>

#include "exporters/exporter.h"
#include "pipeline/data/error.h"
#include "pipeline/files/sha256.h"
#include "pipeline/tiles/tile_files.h"

namespace hexrelief::tiles {

namespace fs = std::filesystem;

void write_tile(const TilePlan& plan, const TileNumber& tile, const mesh_tiles::TileMesh& mesh,
                const TileScene& scene, const Image* texture, int threads, TileReport report) {
    files::OutputSet files;
    const auto place = [&](const char* extension) {
        const fs::path path = tile_file(plan, tile, extension);
        std::error_code none;
        if (fs::exists(path, none) && !fs::is_regular_file(path, none))
            throw Error(ErrorKind::output, path.string() + ": is no regular file; remove it");
        files.place(path);
        return path;
    };
    const fs::path kept = place(".mesh");
    files.files().write(kept, tile_bytes(mesh));
    if (!scene.mesh.empty()) {
        exporters::Scene exported{
            &scene.mesh, texture, std::string("hexrelief ") + HEXRELIEF_VERSION, {}, nullptr};
        exported.threads = threads;
        exported.grid_step_m = plan.grid_step_m;
        exported.origin_m = scene.origin_m;
        exporters::export_scene(exported, plan.config.exporting, place(".glb"), files.files());
    }
    report.plan = plan.stamp;
    report.vertices = scene.mesh.positions.size();
    report.triangles = scene.mesh.triangles.size();
    report.seam_edges = mesh.seam_edges.size();
    report.low_m = scene.low_m;
    report.high_m = scene.high_m;
    report.files = files.written();
    for (files::WrittenFile& file : report.files) file.path = file.path.lexically_relative(plan.folder);
    const fs::path path = place(".json");
    files.files().write(path, report_text(report));
    files.commit();
}

bool is_solved(const TilePlan& plan, const TileNumber& tile) {
    const fs::path path = tile_file(plan, tile, ".json");
    std::error_code none;
    if (!fs::is_regular_file(path, none)) return false;
    try {
        const TileReport report = read_tile_report(path);
        return report.plan == plan.stamp &&
               std::all_of(report.files.begin(), report.files.end(), [&](const files::WrittenFile& file) {
                   const fs::path name = plan.folder / file.path;
                   return fs::is_regular_file(name) && fs::file_size(name) == file.bytes &&
                          files::sha256_of_file(name) == file.sha256;
               });
    } catch (const Error&) {
        return false;
    }
}

}  // namespace hexrelief::tiles
