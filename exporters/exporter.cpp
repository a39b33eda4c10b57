#include "exporters/exporter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "exporters/formats/solid_body.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::exporters {
namespace {

template <typename Vector>
bool finite(const Vector& values) {
    return std::ranges::all_of(values, [](const auto& v) {
        if constexpr (requires { v.z; })
            return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
        else
            return std::isfinite(v.x) && std::isfinite(v.y);
    });
}

// Checks the mesh in one pass over its arrays: a mesh that breaks its contract would make a file that viewers
// refuse or crash on.
void check(const SurfaceMesh& mesh, const Image* texture) {
    const std::size_t vertices = mesh.positions.size();
    if (mesh.triangles.empty() || vertices == 0)
        throw Error(ErrorKind::input, "nothing to export: the mesh has no triangle");
    bool sound = vertices < 0xffffffffu && (mesh.normals.empty() || mesh.normals.size() == vertices) &&
                 (mesh.texcoords.empty() || mesh.texcoords.size() == vertices) && finite(mesh.positions) &&
                 finite(mesh.normals) && finite(mesh.texcoords) &&
                 (!texture || (mesh.texcoords.size() == vertices && !texture->empty()));
    for (const Triangle& t : mesh.triangles) sound = sound && std::max({t[0], t[1], t[2]}) < vertices;
    if (!sound)
        throw std::logic_error("mesh to export has arrays of different length, wrong indices or no numbers");
}

// True if viewers light the mesh of this format, as they do without an unlit material.
bool is_lit(const Scene& scene, const ExportConfig& config, const MeshFormat& format) {
    const bool textured = scene.texture && config.texcoords && config.texture != TextureFormat::none;
    return !format.has_material || !textured || config.material == MaterialKind::lit;
}

ExportConfig with_normals_decided(const Scene& scene, ExportConfig config, const MeshFormat& format) {
    if (config.normals == NormalsKind::automatic)
        config.normals = is_lit(scene, config, format) ? NormalsKind::always : NormalsKind::never;
    return config;
}

// Returns the mesh turned about the z axis so that `up` becomes +Y.
SurfaceMesh turned(SurfaceMesh mesh, const std::array<double, 2>& up) {
    for (std::vector<Vec3f>* vectors : {&mesh.positions, &mesh.normals})
        for (Vec3f& v : *vectors)
            v = {static_cast<float>(up[1] * v.x - up[0] * v.y), static_cast<float>(up[0] * v.x + up[1] * v.y),
                 v.z};
    return mesh;
}

// Returns the camera whose picture the mesh fills: the given one's picture lies on its side.
Calibration framing(const SurfaceMesh& mesh, Calibration camera) {
    double left = 0, right = 0, top = 0, bottom = 0;
    bool is_first = true;
    for (const Vec3f& v : mesh.positions) {
        if (!(v.z < 0)) continue;
        const double x = camera.focal_px * v.x / -v.z, y = camera.focal_px * v.y / v.z;
        left = is_first ? x : std::min(left, x), right = is_first ? x : std::max(right, x);
        top = is_first ? y : std::min(top, y), bottom = is_first ? y : std::max(bottom, y);
        is_first = false;
    }
    camera.cx = -left, camera.cy = -top;
    camera.width = std::max(1, static_cast<int>(std::ceil(right - left)));
    camera.height = std::max(1, static_cast<int>(std::ceil(bottom - top)));
    return camera;
}

// A scene of meshes made of another one's, level by level; it owns them.
struct RemadeScene {
    template <typename Make>
    RemadeScene(const Scene& given, const Make& make) : scene(given) {
        meshes.reserve(1 + given.coarser.size());
        scene.mesh = &meshes.emplace_back(make(*given.mesh));
        for (const SurfaceMesh*& mesh : scene.coarser) mesh = &meshes.emplace_back(make(*mesh));
    }
    Scene scene;
    std::vector<SurfaceMesh> meshes;
};

void export_upright(const Scene& given, const ExportConfig& config, const std::filesystem::path& path,
                    FileTransaction& files) {
    RemadeScene upright(given, [&](const SurfaceMesh& mesh) { return turned(mesh, given.up); });
    upright.scene.up = {0, 1};
    Calibration camera;
    if (given.camera) {
        camera = framing(upright.meshes[0], *given.camera);
        upright.scene.camera = &camera;
    }
    export_scene(upright.scene, config, path, files);
}

// Writes the scene into a file with its origin at the mesh's base.
void export_at_base(Scene scene, const ExportConfig& config, OriginSupport support,
                    const std::filesystem::path& path, FileTransaction& files) {
    const Bounds bounds = bounds_of(scene.mesh->positions);
    const Vec3f base{(bounds.low.x + bounds.high.x) / 2, bounds.low.y, (bounds.low.z + bounds.high.z) / 2};
    if (support == OriginSupport::node) {
        scene.shift_m = {-base.x, -base.y, -base.z};
        return export_scene(scene, config, path, files);
    }
    const RemadeScene moved(scene, [&](SurfaceMesh mesh) {
        for (Vec3f& p : mesh.positions) p = {p.x - base.x, p.y - base.y, p.z - base.z};
        return mesh;
    });
    export_scene(moved.scene, config, path, files);
}

// Returns the scene of the body, in place of the surface, of each level.
RemadeScene solid_scene(const Scene& given, const ExportConfig& config, double unit_mm) {
    RemadeScene solid(given, [&](const SurfaceMesh& surface) {
        SurfaceMesh body = solid_body(surface, config.solid_size_mm, config.solid);
        for (Vec3f& p : body.positions)
            for (float* value : {&p.x, &p.y, &p.z}) *value /= static_cast<float>(unit_mm);
        return body;
    });
    solid.scene.camera = nullptr;  // which sees no body
    solid.scene.is_body = true;
    return solid;
}

// Writes the scene, and its coarser levels into files of their own if the format has no place for them.
void write_levels(Scene scene, const ExportConfig& config, const MeshFormat& format,
                  const std::filesystem::path& path, FileTransaction& files) {
    format.write(scene, config, path, files);
    if (!format.has_separate_levels(config)) return;
    // Each level is written with all others in its scene, so that all are cropped to the same texture.
    for (std::size_t i = 0; i < scene.coarser.size(); ++i) {
        std::swap(scene.mesh, scene.coarser[i]);
        format.write(scene, config, level_path(path, static_cast<int>(i) + 1), files);
    }
}

}  // namespace

// The rows of the formats, each defined beside its writer.
extern const MeshFormat glb_format, gltf_format, drc_format, obj_format, ply_format, stl_format,
    threemf_format, usdz_format, html_format;

const std::vector<const MeshFormat*>& mesh_formats() {
    static const std::vector<const MeshFormat*> all = {&glb_format,     &gltf_format, &drc_format,
                                                       &obj_format,     &ply_format,  &stl_format,
                                                       &threemf_format, &usdz_format, &html_format};
    return all;
}

std::string export_extensions() {
    return joined(mesh_formats(), " ", [](const MeshFormat* format) { return format->extension; });
}

const MeshFormat* find_mesh_format(const std::filesystem::path& path) {
    const std::string extension = extension_of(path);
    const auto& all = mesh_formats();
    const auto found =
        std::ranges::find_if(all, [&](const MeshFormat* format) { return format->extension == extension; });
    return found == all.end() ? nullptr : *found;
}

const MeshFormat& export_format(const std::filesystem::path& path) {
    const MeshFormat* format = find_mesh_format(path);
    if (!format)
        throw Error(ErrorKind::usage, "cannot tell the mesh format of '" + path.string() +
                                          "': its extension is '" + extension_of(path) + "'; use one of " +
                                          export_extensions());
    if (format->names_companions_in_lines &&
        path.filename().string().find_first_of("\r\n") != std::string::npos) {
        std::string name = format->name();
        for (char& letter : name)
            letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
        throw Error(ErrorKind::usage, "an " + name +
                                          " file cannot name the files beside it where its own name, '" +
                                          path.string() + "', has a line break; choose another name");
    }
    return *format;
}

inspect::MeshDescription describe_mesh(const std::filesystem::path& path) {
    const MeshFormat& format = export_format(path);
    inspect::MeshDescription out = format.describe(path);
    out.format = format.name();
    return out;
}

ExportConfig config_of_file(const Scene& scene, const ExportConfig& asked,
                            const std::filesystem::path& path) {
    const MeshFormat& format = export_format(path);
    ExportConfig config = with_normals_decided(scene, asked, format);
    config.compression = format.compression_in(asked);
    if (format.tolerance_px) config.tolerance_px = format.tolerance_px(scene, config, path);
    return config;
}

void export_scene(const Scene& scene, const ExportConfig& asked, const std::filesystem::path& path,
                  FileTransaction& files) {
    const MeshFormat& format = export_format(path);
    const ExportConfig config = with_normals_decided(scene, asked, format);
    if (!scene.mesh) throw std::logic_error("scene to export has no mesh");
    if (scene.up != std::array<double, 2>{0, 1}) {
        ExportConfig without_camera = asked;  // a glTF camera's axis goes through the middle of its picture
        without_camera.camera = false;
        return export_upright(scene, without_camera, path, files);
    }
    check(*scene.mesh, scene.texture);
    for (const SurfaceMesh* mesh : scene.coarser) check(*mesh, scene.texture);
    if (config.solid != SolidKind::none && format.body_unit_mm > 0) {
        const RemadeScene solid = solid_scene(scene, config, format.body_unit_mm);
        return write_levels(solid.scene, config, format, path, files);
    }
    const FileOrigin origin = asked.origin == FileOrigin::automatic ? format.usual_origin : asked.origin;
    if (origin == FileOrigin::base && format.origin != OriginSupport::none) {
        ExportConfig moved = asked;
        moved.origin = FileOrigin::camera;
        return export_at_base(scene, moved, format.origin, path, files);
    }
    write_levels(scene, config, format, path, files);
}

std::vector<std::filesystem::path> export_scene(const Scene& scene, const ExportConfig& config,
                                                const std::filesystem::path& path) {
    FileTransaction files;
    export_scene(scene, config, path, files);
    files.commit();
    return files.paths();
}

std::uint64_t export_size(const Scene& scene, const ExportConfig& config, const std::filesystem::path& path) {
    FileTransaction files(FileTransaction::Counting{});
    export_scene(scene, config, path, files);
    return files.bytes();
}

}  // namespace hexrelief::exporters
