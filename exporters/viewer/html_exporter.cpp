#include "exporters/viewer/html_exporter.h"

#include <algorithm>
#include <future>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/gltf/gltf_exporter.h"
#include "exporters/inspect/describe_formats.h"
#include "exporters/viewer/html_text.h"
#include "exporters/viewer/small_picture.h"
#include "exporters/viewer/viewer_page.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::exporters {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Both sides of a silhouette lie on one line of the photograph. If this line is rounded separately on each
// side, gaps of that width show the background. With this finer tolerance they are too narrow to be seen; it
// is used if it costs at most this factor in bytes.
constexpr double kFineTolerance_px = 0.02, kMostForFine = 1.3;

// Returns the size of the finest level as a GLB without a texture.
std::size_t mesh_bytes(const Scene& scene, ExportConfig config, Compression compression,
                       const fs::path& path) {
    Scene bare = scene;
    bare.coarser.clear();
    bare.extras_json.clear();
    config.texture = TextureFormat::none;
    config.compression = compression;
    return glb_bytes(bare, config, path).size();
}

// Returns the configuration for the mesh in the page, which ignores the choices made for other files.
ExportConfig page_config(ExportConfig config) {
    config.normals = NormalsKind::never;
    config.material = MaterialKind::unlit;
    config.camera = false;
    config.lod_storage = LevelStorage::inside;
    config.compression = Compression::meshopt;
    return config;
}

// Returns a finer tolerance than config's, px, if it costs few bytes. meshopt_bytes: size of the
// mesh at config's tolerance.
double page_tolerance_px(const Scene& scene, const ExportConfig& config, const fs::path& path,
                         std::size_t meshopt_bytes) {
    ExportConfig fine = page_config(config);
    fine.tolerance_px = std::min(config.tolerance_px, kFineTolerance_px);
    const std::size_t fine_bytes = mesh_bytes(scene, fine, Compression::meshopt, path);
    const bool is_cheap =
        static_cast<double>(fine_bytes) <= kMostForFine * static_cast<double>(meshopt_bytes);
    return is_cheap ? fine.tolerance_px : config.tolerance_px;
}

Json camera_json(const Scene& scene) {
    const Calibration& camera = *scene.camera;
    return {{"focal_px", camera.focal_px},
            {"cx", camera.cx},
            {"cy", camera.cy},
            {"baseline_m", camera.baseline_m},
            {"doffs_px", camera.doffs_px},
            {"metric", camera.metric},
            {"width", camera.width > 0 ? camera.width : scene.image_width},
            {"height", camera.height > 0 ? camera.height : scene.image_height}};
}

Json levels_json(const Scene& scene) {
    Json json = Json::array();
    const auto add = [&](const SurfaceMesh& mesh) {
        json.push_back({{"vertices", mesh.positions.size()}, {"triangles", mesh.triangles.size()}});
    };
    add(*scene.mesh);
    for (const SurfaceMesh* mesh : scene.coarser) add(*mesh);
    return json;
}

Json pictures_json(const PageContent& page) {
    Json json = Json::array();
    for (const auto& [name, label, image] : page.pictures)
        json.push_back({{"name", name}, {"label", label}, {"source", small_picture(image)}});
    return json;
}

std::string facts_json(const Scene& scene, const Json& bytes, const fs::path& path) {
    Json json;
    json["name"] = path.stem().string();
    json["generator"] = scene.generator;
    json["camera"] = camera_json(scene);
    json["levels"] = levels_json(scene);
    json["bytes"] = bytes;
    json["figures"] = Json::array();
    json["pictures"] = Json::array();
    if (scene.page) {
        for (const auto& [name, value, decimals, unit] : scene.page->figures)
            json["figures"].push_back(
                {{"name", name}, {"value", value}, {"decimals", decimals}, {"unit", unit}});
        json["pictures"] = pictures_json(*scene.page);
    }
    return script_escaped(
        json.dump(-1, ' ', false, Json::error_handler_t::replace));  // names may not be UTF-8
}

}  // namespace

bool has_viewer() {
    return !viewer_page().empty();
}

namespace {

// Returns the tolerance of the page, px; may be finer than config.tolerance_px, see above.
double page_tolerance_px(const Scene& scene, const ExportConfig& config, const fs::path& path) {
    return page_tolerance_px(scene, config, path, mesh_bytes(scene, config, Compression::meshopt, path));
}

// Writes the page. The scene needs a camera and the size of its image. The page holds the mesh as a GLB with
// EXT_meshopt_compression, with all levels of detail and without normals, whatever config says; the texture
// is as config says. The page's title is path's stem.
void write_html(const Scene& scene, const ExportConfig& config, const fs::path& path,
                FileTransaction& files) {
    if (!has_viewer()) throw Error(ErrorKind::output, "cannot write '" + path.string() + "': " + kNoViewer);
    if (!scene.camera || scene.image_width <= 0 || scene.image_height <= 0)
        throw std::logic_error("a page needs the scene's camera and the size of its image");
    const auto count = [&](Compression compression) { return mesh_bytes(scene, config, compression, path); };
    std::future<std::size_t> draco = start_work(scene.threads, [&] { return count(Compression::draco); });
    const std::size_t meshopt = count(Compression::meshopt);
    ExportConfig held = page_config(config);
    held.tolerance_px = page_tolerance_px(scene, config, path, meshopt);
    const std::string glb = base64(glb_bytes(scene, held, path));
    const Json bytes = {{"plain", count(Compression::none)}, {"draco", draco.get()}, {"meshopt", meshopt}};
    const std::string title = html_escaped(path.stem().string()), facts = facts_json(scene, bytes, path);
    files.write(path, filled(viewer_page(),
                             {{"@title@", title}, {"@title@", title}, {"@facts@", facts}, {"@glb@", glb}}));
}

}  // namespace

extern const MeshFormat html_format = {
    .extension = ".html",
    .holds =
        "a page that shows the relief in a browser, with nothing but itself ([viewer](viewer/README.md))",
    .write = write_html,
    .describe = inspect::describe_html,
    .colours = ColourStorage::texture,
    .has_material = true,
    .compression = Compression::meshopt,
    .tolerance_px = page_tolerance_px,
    .levels = LevelSupport::inside,
    .is_page = true,
};

}  // namespace hexrelief::exporters
