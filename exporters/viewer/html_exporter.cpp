#include "exporters/viewer/html_exporter.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <future>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "exporters/core/mesh_format.h"
#include "exporters/formats/gltf/gltf_exporter.h"
#include "exporters/images/image_writer.h"
#include "exporters/images/resize.h"
#include "exporters/inspect/describe_formats.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/data/start_work.h"

// Embeds a file as bytes between two symbols. The assembler reads it; as an array in C++ it would cost the
// compiler a gigabyte of memory.
#define HEXRELIEF_EMBED(symbol, file)                                                       \
    asm(".pushsection .rodata\n"                                                            \
        ".hidden " #symbol ", " #symbol                                                     \
        "_end\n"                                                                            \
        ".global " #symbol ", " #symbol "_end\n" #symbol ": .incbin \"" file "\"\n" #symbol \
        "_end: .byte 0\n"                                                                   \
        ".popsection\n");                                                                   \
    extern "C" const char symbol[], symbol##_end[]  // NOLINT(bugprone-macro-parentheses): a declared name

#ifdef HEXRELIEF_PAGES
HEXRELIEF_EMBED(hexrelief_viewer_page, HEXRELIEF_PAGES "/page.html");
HEXRELIEF_EMBED(hexrelief_empty_gallery, HEXRELIEF_PAGES "/gallery.html");
#endif

namespace hexrelief::exporters {
namespace {

// The page templates that build.mjs makes; empty if the program was built without its viewer. In this order
// they contain the marks "@title@" (twice), and "@facts@" and "@glb@" or "@columns@" and "@rows@".
#ifdef HEXRELIEF_PAGES
const std::string_view kViewerPage(hexrelief_viewer_page, hexrelief_viewer_page_end),
    kEmptyGallery(hexrelief_empty_gallery, hexrelief_empty_gallery_end);
#else
constexpr std::string_view kViewerPage, kEmptyGallery;
#endif

// Longer side in px, and quality; the best first.
constexpr std::pair<int, int> kSizes[] = {{480, 75}, {480, 50}, {360, 40}, {240, 30}, {120, 30}};
constexpr std::size_t kMostBytes = 16000;

Image shrunk(const Image& image, int longest_px) {
    const double scale = static_cast<double>(longest_px) / std::max(image.width, image.height);
    if (scale >= 1) return image;
    const auto side = [&](int size) { return std::max(1, static_cast<int>(size * scale)); };
    return resized(image, side(image.width), side(image.height));
}

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
    Json json = {{"name", path.stem().string()},
                 {"generator", scene.generator},
                 {"camera", camera_json(scene)},
                 {"levels", levels_json(scene)},
                 {"bytes", bytes},
                 {"figures", Json::array()},
                 {"pictures", Json::array()}};
    if (scene.page) {
        for (const auto& [name, value, decimals, unit] : scene.page->figures)
            json["figures"].push_back(
                {{"name", name}, {"value", value}, {"decimals", decimals}, {"unit", unit}});
        json["pictures"] = pictures_json(*scene.page);
    }
    return script_escaped(
        json.dump(-1, ' ', false, Json::error_handler_t::replace));  // names may not be UTF-8
}

std::string printed(double value, int decimals) {
    std::string out = fixed(value, decimals);
    // Thousands are separated by a narrow no-break space.
    const std::size_t point = std::min(out.find('.'), out.size());
    for (std::size_t at = point; at > 3 && std::isdigit(static_cast<unsigned char>(out[at - 4]));) {
        at -= 3;
        out.insert(at, "\u202f");
    }
    return out;
}

std::string head(const std::string& name) {
    return "<th scope=\"col\"><button>" + html_escaped(name) + "</button></th>";
}

std::string row(const std::vector<GalleryColumn>& columns, const GalleryEntry& entry) {
    // Without "./", the first folder's name could look like a URL scheme.
    std::string out =
        "<tr><td><a href=\"./" + html_escaped(percent_encoded(entry.link.generic_string())) + "\">";
    if (!entry.picture.empty()) out += "<img alt=\"\" src=\"" + html_escaped(entry.picture) + "\">";
    out += html_escaped(entry.name) + "</a></td>";
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const double value = entry.values.at(i);
        out += "<td data-name=\"" + html_escaped(columns[i].name) + "\"";
        out += std::isfinite(value)
                   ? " data-value=\"" + number_text(value, 17) + "\">" + printed(value, columns[i].decimals)
                   : ">–";
        out += "</td>";
    }
    return out + "</tr>\n";
}

}  // namespace

std::string base64(const std::vector<std::uint8_t>& bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t left = bytes.size() - i;
        const std::uint32_t three = (std::uint32_t(bytes[i]) << 16) |
                                    (left > 1 ? std::uint32_t(bytes[i + 1]) << 8 : 0u) |
                                    (left > 2 ? std::uint32_t(bytes[i + 2]) : 0u);
        out += kDigits[three >> 18];
        out += kDigits[(three >> 12) & 63];
        out += left > 1 ? kDigits[(three >> 6) & 63] : '=';
        out += left > 2 ? kDigits[three & 63] : '=';
    }
    return out;
}

std::string html_escaped(std::string_view text) {
    static const std::map<char, const char*> kNames = {
        {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}};
    std::string out;
    for (const char c : text)
        if (const auto name = kNames.find(c); name != kNames.end())
            out += name->second;
        else
            out += c;
    return out;
}

std::string script_escaped(const std::string& json) {
    return replaced(json, '<', "\\u003c");
}

std::string filled(std::string_view page,
                   const std::vector<std::pair<std::string_view, std::string_view>>& values) {
    std::string out;
    for (const auto& [mark, value] : values) {
        const std::size_t at = page.find(mark);
        if (at == std::string_view::npos)
            throw std::logic_error("the viewer's page has no " + std::string(mark));
        out += page.substr(0, at);
        out += value;
        page.remove_prefix(at + mark.size());
    }
    return out += page;
}

std::string small_picture(const Image& image) {
    std::vector<std::uint8_t> bytes;
    for (const auto& [longest_px, quality] : kSizes) {
        bytes = encode_webp(shrunk(image, longest_px), quality);
        if (bytes.size() <= kMostBytes) break;
    }
    return "data:image/webp;base64," + base64(bytes);
}

bool has_viewer() {
    return !kViewerPage.empty();
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
    if (!has_viewer()) fail_writing(path, kNoViewer);
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
    files.write(path, filled(kViewerPage,
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

std::string gallery_page(const std::string& title, const std::vector<GalleryColumn>& columns,
                         const std::vector<GalleryEntry>& entries) {
    if (!has_viewer()) throw Error(ErrorKind::output, std::string("no gallery can be made: ") + kNoViewer);
    const std::string text = html_escaped(title);
    std::string heads = head("Result"), rows;
    for (const GalleryColumn& column : columns) heads += head(column.name);
    for (const GalleryEntry& entry : entries) rows += row(columns, entry);
    return filled(kEmptyGallery,
                  {{"@title@", text}, {"@title@", text}, {"@columns@", heads}, {"@rows@", rows}});
}

}  // namespace hexrelief::exporters
