// write_scenes FOLDER: writes every kind of glTF file that the exporter knows, and expected.json, for
// validate.mjs.
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>

#include "tests/exporters/sample_scene.h"

using namespace hexrelief;

namespace {

nlohmann::json positions_of(const SurfaceMesh& mesh) {
    nlohmann::json out = nlohmann::json::array();
    for (const Vec3f& p : mesh.positions) {
        for (const float value : {p.x, p.y, p.z}) out.push_back(value);
    }
    return out;
}

void write_all(const std::filesystem::path& folder) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    const SurfaceMesh small = sample_mesh(24, 18), large = sample_mesh(300, 250);
    const Image colour = sample_texture(64, 48), grey = sample_texture(64, 48, 1);
    nlohmann::json expected;
    const auto write = [&](const std::string& name, const SurfaceMesh& mesh, const Image* texture, bool draco,
                           TextureFormat format = TextureFormat::jpeg) {
        ExportConfig config;
        config.draco.enabled = draco;
        config.texture_format = format;
        const Scene scene{&mesh, texture, kGenerator,
                          R"({"mesh": {"seed": 18446744073709551615, "name": "a \"b\""}})"};
        export_scene(scene, config, folder / name);
        auto& want = expected[name];
        want = {{"vertices", mesh.positions.size()},
                {"triangles", mesh.triangles.size()},
                {"textured", texture != nullptr},
                {"texture_size", "64x48"},
                {"generator", kGenerator}};
        if (&mesh == &small) {
            want["positions"] = positions_of(mesh);
            want["tolerance"] = draco ? 2.0 / 4095 * 0.9 : 0.0;  // half a step each way, in three dimensions
        }
    };
    write("plain.glb", small, &colour, false);
    write("plain-bare.glb", small, nullptr, false);
    write("plain-png.glb", small, &colour, false, TextureFormat::png);
    write("plain-grey.glb", small, &grey, false);
    write("plain-large.glb", large, &colour, false);
    write("draco.glb", small, &colour, true);
    write("draco-bare.glb", small, nullptr, true);
    write("draco-large.glb", large, &colour, true);
    write("split with spaces 100%.gltf", small, &colour, false);
    write("split-bare.gltf", small, nullptr, false);
    write("split-draco.gltf", small, &colour, true, TextureFormat::png);
    write("split-draco-bare.gltf", small, nullptr, true);
    put(folder / "expected.json", expected.dump());
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
