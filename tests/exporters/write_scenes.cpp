// write_scenes FOLDER: writes every kind of glTF file that the exporter knows, and expected.json, for
// validate.mjs.
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>

#include "exporters/formats/solid_body.h"
#include "tests/exporters/sample_scene.h"

using namespace hexrelief;

namespace {

nlohmann::json positions_of(const hexrelief::SurfaceMesh& mesh) {
    nlohmann::json out = nlohmann::json::array();
    for (const hexrelief::Vec3f& p : mesh.positions)
        for (const float value : {p.x, p.y, p.z}) out.push_back(value);
    return out;
}

nlohmann::json camera_json(const hexrelief::Calibration& camera) {
    return {
        {"focal", camera.focal_px}, {"cx", camera.cx}, {"cy", camera.cy}, {"baseline", camera.baseline_m}};
}

class Writer {
  public:
    explicit Writer(const std::filesystem::path& folder) : folder_(folder) {
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
    }
    ~Writer() { hexrelief::exporters::put(folder_ / "expected.json", expected_.dump()); }

    // vertex_by_vertex: expected.json lists the value of every vertex.
    void write(const std::string& name, const hexrelief::SurfaceMesh& mesh, const hexrelief::Image* texture,
               const hexrelief::exporters::ExportConfig& config, bool vertex_by_vertex = true,
               const std::vector<const hexrelief::SurfaceMesh*>& coarser = {}) {
        hexrelief::Calibration camera = hexrelief::exporters::sample_camera();
        camera.width = 64;
        camera.height = 48;
        const hexrelief::exporters::Scene scene{
            &mesh,
            texture,
            hexrelief::exporters::kGenerator,
            R"({"mesh": {"seed": 18446744073709551615, "name": "a \"b\""}})",
            &camera,
            coarser};
        hexrelief::exporters::export_scene(scene, config, folder_ / name);
        const bool textured =
            texture && config.texcoords && config.texture != hexrelief::exporters::TextureFormat::none;
        auto& want = expected_[name];
        want = {{"vertices", mesh.positions.size()},
                {"triangles", mesh.triangles.size()},
                {"textured", textured},
                {"material", static_cast<int>(config.material)},
                {"texcoords", texture && config.texcoords},
                {"normals", has_normals(config, textured)},
                {"generator", hexrelief::exporters::kGenerator},
                {"extensions", extensions(config, textured)}};
        want["levels"] = nlohmann::json::array();
        for (const hexrelief::SurfaceMesh* level : coarser) want["levels"].push_back(level->positions.size());
        want["camera"] = camera_json(camera);
        if (!vertex_by_vertex) return;
        want["positions"] = positions_of(mesh);
        want["camera"] = camera_json(camera);
        const bool exact = config.compression == hexrelief::exporters::Compression::none;
        want["tolerance_px"] = exact ? 1e-6 : config.tolerance_px;
        want["tolerance_deg"] = exact ? 1e-3 : config.tolerance_deg;
        for (const hexrelief::Vec3f& n : mesh.normals)
            for (const float v : {n.x, n.y, n.z}) want["normal_values"].push_back(v);
        for (const hexrelief::Vec2f& t : mesh.texcoords)
            for (const float v : {t.x, t.y}) want["texcoord_values"].push_back(v);
        if (texture) want["image"] = {texture->width, texture->height};
    }

    // The closed body of the mesh.
    void write_body(const std::string& name, const hexrelief::SurfaceMesh& mesh,
                    const hexrelief::Image* texture, const hexrelief::exporters::ExportConfig& config) {
        write(name, mesh, texture, config, false);
        const hexrelief::SurfaceMesh body =
            hexrelief::exporters::solid_body(mesh, config.solid_size_mm, config.solid);
        expected_[name]["vertices"] = body.positions.size();
        expected_[name]["triangles"] = body.triangles.size();
        expected_[name]["normals"] = false;
        expected_[name]["body"] = true;
    }

  private:
    static bool has_normals(const hexrelief::exporters::ExportConfig& config, bool textured) {
        if (config.normals != hexrelief::exporters::NormalsKind::automatic)
            return config.normals == hexrelief::exporters::NormalsKind::always;
        return !textured || config.material == hexrelief::exporters::MaterialKind::lit;
    }
    static nlohmann::json extensions(const hexrelief::exporters::ExportConfig& config, bool textured) {
        nlohmann::json out = nlohmann::json::array();
        if (config.compression == hexrelief::exporters::Compression::draco)
            out.push_back("KHR_draco_mesh_compression");
        if (config.compression == hexrelief::exporters::Compression::quantized ||
            config.compression == hexrelief::exporters::Compression::meshopt)
            out.push_back("KHR_mesh_quantization");
        if (config.compression == hexrelief::exporters::Compression::meshopt)
            out.push_back("EXT_meshopt_compression");
        if (textured && config.material == hexrelief::exporters::MaterialKind::unlit)
            out.push_back("KHR_materials_unlit");
        if (textured && config.texture == hexrelief::exporters::TextureFormat::webp)
            out.push_back("EXT_texture_webp");
        return out;
    }
    std::filesystem::path folder_;
    nlohmann::json expected_;
};

void write_all(const std::filesystem::path& folder) {
    const hexrelief::SurfaceMesh small = hexrelief::exporters::sample_mesh(24, 18);
    hexrelief::SurfaceMesh large = hexrelief::exporters::sample_mesh(300, 250);
    hexrelief::exporters::add_provenance(large);
    const hexrelief::Image colour = hexrelief::exporters::sample_texture(64, 48),
                           grey = hexrelief::exporters::sample_texture(64, 48, 1);
    hexrelief::SurfaceMesh part = small;  // shows only a part of the picture
    hexrelief::exporters::add_provenance(part);
    for (hexrelief::Vec2f& t : part.texcoords) t = {0.25f + t.x / 4, 0.5f + t.y / 3};
    const hexrelief::SurfaceMesh half = hexrelief::exporters::sample_mesh(12, 9),
                                 quarter = hexrelief::exporters::sample_mesh(6, 5);
    Writer out(folder);
    const std::pair<const char*, hexrelief::exporters::Compression> compressions[] = {
        {"plain", hexrelief::exporters::Compression::none},
        {"draco", hexrelief::exporters::Compression::draco},
        {"quantized", hexrelief::exporters::Compression::quantized},
        {"meshopt", hexrelief::exporters::Compression::meshopt}};
    for (const auto& [name, compression] : compressions) {
        const std::string stem = name;
        hexrelief::exporters::ExportConfig config{.compression = compression,
                                                  .normals = hexrelief::exporters::NormalsKind::always};
        out.write(stem + ".glb", small, &colour, config);
        out.write(stem + "-bare.glb", small, nullptr, config);
        out.write(stem + "-large.glb", large, &colour, config, false);
        out.write("split with spaces 100% " + stem + ".gltf", small, &colour, config);
        out.write("split-bare-" + stem + ".gltf", small, nullptr, config);
        out.write(stem + "-part.glb", part, &colour, config);
        hexrelief::exporters::ExportConfig inside = config;
        inside.lod_storage = hexrelief::exporters::LevelStorage::inside;
        out.write(stem + "-lod.glb", small, &colour, inside, true, {&half, &quarter});
        out.write("split-lod-" + stem + ".gltf", small, nullptr, inside, true, {&half, &quarter});
        hexrelief::exporters::ExportConfig fine = config;
        fine.tolerance_px = 0.002;  // more than 16 bits a coordinate
        fine.tolerance_deg = 0.02;
        out.write(stem + "-fine.glb", small, &colour, fine);
        hexrelief::exporters::ExportConfig coarse = config;
        coarse.tolerance_px = 0.6;  // 8 bits suffice
        coarse.tolerance_deg = 5;
        out.write(stem + "-coarse.glb", small, &colour, coarse);
        hexrelief::exporters::ExportConfig shapes = config;
        shapes.normals = hexrelief::exporters::NormalsKind::never;
        shapes.texcoords = false;
        out.write(stem + "-positions.glb", small, &colour, shapes);
        hexrelief::exporters::ExportConfig webp = config;
        webp.texture = hexrelief::exporters::TextureFormat::webp;
        webp.texture_max_px = 20;
        out.write(stem + "-webp.glb", part, &colour, webp);
        hexrelief::exporters::ExportConfig automatic = config;
        automatic.normals = hexrelief::exporters::NormalsKind::automatic;
        for (const auto& [kind, material] :
             {std::pair{"-emissive.glb", hexrelief::exporters::MaterialKind::emissive},
              {"-unlit.glb", hexrelief::exporters::MaterialKind::unlit},
              {"-lit.glb", hexrelief::exporters::MaterialKind::lit}}) {
            automatic.material = material;
            out.write(stem + kind, small, &colour, automatic);
        }
        hexrelief::exporters::ExportConfig none = config;
        none.texture = hexrelief::exporters::TextureFormat::none;
        none.normals = hexrelief::exporters::NormalsKind::never;
        out.write(stem + "-no-image.glb", small, &colour, none);
    }
    hexrelief::exporters::ExportConfig body{.solid = hexrelief::exporters::SolidKind::base};
    out.write_body("body.glb", small, &colour, body);
    body.solid = hexrelief::exporters::SolidKind::shell;
    out.write_body("split-body.gltf", small, nullptr, body);
    hexrelief::exporters::ExportConfig png;
    png.texture = hexrelief::exporters::TextureFormat::png;
    out.write("plain-png.glb", small, &colour, png);
    out.write("plain-grey.glb", small, &grey, {});
    png.compression = hexrelief::exporters::Compression::draco;
    out.write("split-draco.gltf", small, &colour, png);
    hexrelief::exporters::ExportConfig webp;
    webp.texture = hexrelief::exporters::TextureFormat::webp;
    out.write("split-webp.gltf", small, &grey, webp);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    try {
        write_all(argv[1]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
