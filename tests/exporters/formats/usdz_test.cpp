// Tests USDZ by the test's own small parser. tests/clients/ shows the files in other programs.
#include <cstring>
#include <sstream>

#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

struct StoredFile {
    std::string name, bytes;
};

// Walks from header to header, since the archive has nothing between its files.
std::vector<StoredFile> read_archive(const std::string& archive) {
    std::vector<StoredFile> files;
    std::size_t at = 0;
    const auto number = [&](std::size_t from, std::size_t width) {
        std::uint32_t value = 0;
        std::memcpy(&value, archive.data() + from, width);
        return std::size_t{value};
    };
    while (archive.compare(at, 4, "PK\x03\x04") == 0) {
        EXPECT_EQ(number(at + 8, 2), 0u) << "compressed";
        EXPECT_EQ(number(at + 18, 4), number(at + 22, 4));
        const std::size_t name = number(at + 26, 2), extra = number(at + 28, 2), size = number(at + 22, 4);
        const std::size_t start = at + 30 + name + extra;
        EXPECT_EQ(start % 64, 0u);
        files.push_back({archive.substr(at + 30, name), archive.substr(start, size)});
        at = start + size;
    }
    EXPECT_EQ(archive.compare(at, 4, "PK\x01\x02"), 0);
    return files;
}

std::vector<float> numbers(const std::string& text, const std::string& name) {
    const std::size_t begin = text.find(name + " = [");
    EXPECT_NE(begin, std::string::npos) << name;
    if (begin == std::string::npos) return {};
    std::string list = text.substr(begin + name.size() + 4,
                                   text.find(']', begin + name.size() + 4) - begin - name.size() - 4);
    for (char& c : list)
        if (c == '(' || c == ')' || c == ',') c = ' ';
    std::istringstream stream(list);
    std::vector<float> out;
    for (float value; stream >> value;) out.push_back(value);
    return out;
}

// Without a camera positions come back to the bit.
TEST(Usdz, ComesBack) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Image texture = sample_texture(64, 48);
    ExportConfig config{.material = MaterialKind::lit, .origin = FileOrigin::camera};
    EXPECT_EQ(export_scene({&mesh, &texture, kGenerator, ""}, config, folder / "a.usdz").size(), 1u);
    const std::vector<StoredFile> files = read_archive(contents(folder / "a.usdz"));
    ASSERT_EQ(files.size(), 2u);
    EXPECT_EQ(files[0].name, "relief.usda");
    EXPECT_EQ(files[1].name, "texture.jpg");
    EXPECT_EQ(files[1].bytes.substr(0, 2), "\xff\xd8");
    const std::string& text = files[0].bytes;
    EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
    EXPECT_CONTAINS(text, "@texture.jpg@");
    const std::vector<float> points = numbers(text, "point3f[] points"),
                             normals = numbers(text, "normal3f[] normals"),
                             texcoords = numbers(text, "texCoord2f[] primvars:st"),
                             indices = numbers(text, "int[] faceVertexIndices");
    ASSERT_EQ(points.size(), 3 * mesh.positions.size());
    ASSERT_EQ(normals.size(), 3 * mesh.positions.size());
    ASSERT_EQ(texcoords.size(), 2 * mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        EXPECT_EQ((Vec3f{points[3 * i], points[3 * i + 1], points[3 * i + 2]}), mesh.positions[i]);
        EXPECT_NEAR(normals[3 * i], mesh.normals[i].x, 0.01);
        EXPECT_NEAR(normals[3 * i + 1], mesh.normals[i].y, 0.01);
        EXPECT_NEAR(normals[3 * i + 2], mesh.normals[i].z, 0.01);
        EXPECT_NEAR(texcoords[2 * i], mesh.texcoords[i].x, 0.1 / 64);
        EXPECT_NEAR(texcoords[2 * i + 1], 1 - mesh.texcoords[i].y, 0.1 / 64);
    }
    ASSERT_EQ(indices.size(), 3 * mesh.triangles.size());
    for (std::size_t i = 0; i < indices.size(); ++i) EXPECT_EQ(indices[i], mesh.triangles[i / 3][i % 3]);
    EXPECT_EQ(numbers(text, "int[] faceVertexCounts"), std::vector<float>(mesh.triangles.size(), 3));
}

TEST(Usdz, NumbersHaveTheDigitsThatTheToleranceNeeds) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Calibration camera = sample_camera();
    Scene scene{&mesh, nullptr, kGenerator, ""};
    scene.camera = &camera;
    ExportConfig config{.origin = FileOrigin::camera};
    std::size_t bytes = 1u << 30;
    for (const double tolerance : {0.01, 0.1, 1.0}) {
        config.tolerance_px = tolerance;
        export_scene(scene, config, folder / "a.usdz");
        const std::string text = read_archive(contents(folder / "a.usdz")).at(0).bytes;
        EXPECT_LT(text.size(), bytes);
        bytes = text.size();
        const std::vector<float> points = numbers(text, "point3f[] points");
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            const Vec3f& p = mesh.positions[i];
            const double focal = camera.focal_px, depth = -points[3 * i + 2];
            EXPECT_NEAR(focal * points[3 * i] / depth, focal * p.x / -p.z, tolerance);
            EXPECT_NEAR(focal * points[3 * i + 1] / depth, focal * p.y / -p.z, tolerance);
            EXPECT_NEAR(focal * camera.baseline_m / depth, focal * camera.baseline_m / -p.z, tolerance);
        }
    }
}

TEST(Usdz, MaterialsAndTextures) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(4, 4);
    const Image texture = sample_texture(16, 16);
    ExportConfig config;
    config.texture = TextureFormat::webp;  // USDZ must not contain WebP
    export_scene({&mesh, &texture, "a \"b\"\n", ""}, config, folder / "a.usdz");
    std::vector<StoredFile> files = read_archive(contents(folder / "a.usdz"));
    EXPECT_EQ(files.at(1).name, "texture.jpg");
    EXPECT_CONTAINS(files[0].bytes, "inputs:emissiveColor.connect");
    EXPECT_EQ(files[0].bytes.find("normal3f[]"), std::string::npos);
    EXPECT_CONTAINS(files[0].bytes, "doc = \"a ?b??\"");
    config.texture = TextureFormat::png;
    config.material = MaterialKind::lit;
    export_scene({&mesh, &texture, kGenerator, ""}, config, folder / "a.usdz");
    files = read_archive(contents(folder / "a.usdz"));
    EXPECT_EQ(files.at(1).name, "texture.png");
    EXPECT_CONTAINS(files[0].bytes, "inputs:diffuseColor.connect");
    EXPECT_EQ(files[0].bytes.find("emissive"), std::string::npos);
    export_scene({&mesh, nullptr, kGenerator, ""}, {}, folder / "a.usdz");
    files = read_archive(contents(folder / "a.usdz"));
    EXPECT_EQ(files.size(), 1u);
    EXPECT_EQ(files[0].bytes.find("UsdUVTexture"), std::string::npos);
    EXPECT_CONTAINS(files[0].bytes, "normal3f[]");
}

}  // namespace
}  // namespace hexrelief::exporters
