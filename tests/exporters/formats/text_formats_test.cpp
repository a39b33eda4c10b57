// Tests OBJ, PLY and STL by the tests' own small parsers.
#include <cstring>
#include <sstream>

#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

struct ObjFile {
    std::vector<Vec3f> positions, normals;
    std::vector<Vec2f> texcoords;
    std::vector<std::string> faces;
    std::string library, material;
};

ObjFile read_obj(const std::filesystem::path& path) {
    ObjFile out;
    std::ifstream stream(path);
    for (std::string line; std::getline(stream, line);) {
        std::istringstream words(line);
        std::string key, rest;
        words >> key;
        Vec3f v;
        if (key == "v" || key == "vn") {
            EXPECT_TRUE(words >> v.x >> v.y >> v.z) << line;
            (key == "v" ? out.positions : out.normals).push_back(v);
        } else if (key == "vt") {
            EXPECT_TRUE(words >> v.x >> v.y) << line;
            out.texcoords.push_back({v.x, v.y});
        } else if (key == "f") {
            out.faces.push_back(line);
        } else if (key == "mtllib") {
            words >> out.library;
        } else if (key == "usemtl") {
            words >> out.material;
        } else {
            EXPECT_TRUE(key == "#" || key == "o") << line;
        }
    }
    return out;
}

TEST(Obj, ComesBackToTheBit) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Image texture = sample_texture(64, 48);
    const auto paths = export_scene({&mesh, &texture, kGenerator, ""}, {}, folder / "relief.obj");
    const ObjFile obj = read_obj(paths.at(0));
    EXPECT_EQ(obj.positions, mesh.positions);
    EXPECT_EQ(obj.normals, mesh.normals);
    ASSERT_EQ(obj.texcoords.size(), mesh.texcoords.size());
    for (std::size_t i = 0; i < obj.texcoords.size(); ++i) {
        EXPECT_EQ(obj.texcoords[i].x, mesh.texcoords[i].x);
        EXPECT_EQ(obj.texcoords[i].y, 1 - mesh.texcoords[i].y);
    }
    ASSERT_EQ(obj.faces.size(), mesh.triangles.size());
    for (std::size_t i = 0; i < obj.faces.size(); ++i) {
        std::string expected = "f";
        for (const std::uint32_t vertex : mesh.triangles[i]) {
            const std::string number = std::to_string(vertex + 1);
            expected += " " + number + "/" + number + "/" + number;
        }
        EXPECT_EQ(obj.faces[i], expected);
    }
    EXPECT_EQ(obj.library, paths.at(1).filename());
    const std::string material = contents(paths[1]);
    EXPECT_CONTAINS(material, "newmtl " + obj.material + "\n");
    EXPECT_CONTAINS(material, "map_Kd " + paths.at(2).filename().string() + "\n");
    EXPECT_EQ(contents(paths[2]).substr(0, 2), "\xff\xd8");
}

TEST(Obj, WithoutTextureOrNormals) {
    const TemporaryFolder folder;
    SurfaceMesh mesh = sample_mesh(4, 4);
    const auto paths = export_scene({&mesh, nullptr, kGenerator, ""}, {}, folder / "a.obj");
    EXPECT_EQ(paths.size(), 2u);
    ObjFile obj = read_obj(paths[0]);
    EXPECT_TRUE(obj.texcoords.empty());
    EXPECT_EQ(obj.faces.at(0), "f 1//1 5//5 2//2");
    EXPECT_EQ(contents(paths.at(1)).find("map_Kd"), std::string::npos);
    mesh.normals.clear();
    export_scene({&mesh, nullptr, kGenerator, ""}, {}, folder / "a.obj");
    obj = read_obj(folder / "a.obj");
    EXPECT_TRUE(obj.normals.empty());
    EXPECT_EQ(obj.faces.at(0), "f 1 5 2");
}

// Readers join faces by their positions' numbers.
TEST(Obj, VerticesAtOnePlaceShareAPosition) {
    const TemporaryFolder folder;
    SurfaceMesh mesh = sample_mesh(4, 4);
    mesh.normals.clear();
    mesh.positions.push_back(mesh.positions[5]);
    mesh.texcoords.push_back({0.9f, 0.9f});
    mesh.image_points.push_back(mesh.image_points[5]);
    mesh.disparities.push_back(mesh.disparities[5]);
    mesh.triangles.push_back({0, 16, 1});
    const Image texture = sample_texture(8, 8);
    export_scene({&mesh, &texture, kGenerator, ""}, {}, folder / "a.obj");
    const ObjFile obj = read_obj(folder / "a.obj");
    EXPECT_EQ(obj.positions.size(), 16u);
    EXPECT_EQ(obj.texcoords.size(), 17u);
    EXPECT_EQ(obj.faces.back(), "f 1/1 6/17 2/2");
}

TEST(Obj, TextureNeverTakesThePhotographsName) {
    const TemporaryFolder folder;
    put(folder / "photo.png", "the input");
    put(folder / "photo.jpg", "the input");
    const SurfaceMesh mesh = sample_mesh(4, 4);
    const Image texture = sample_texture(8, 8);
    for (const TextureFormat format : {TextureFormat::png, TextureFormat::jpeg}) {
        ExportConfig config{.texture = format};
        export_scene({&mesh, &texture, kGenerator, ""}, config, folder / "photo.obj");
        export_scene({&mesh, &texture, kGenerator, ""}, config, folder / "photo.gltf");
    }
    EXPECT_EQ(contents(folder / "photo.png"), "the input");
    EXPECT_EQ(contents(folder / "photo.jpg"), "the input");
}

// Returns a bilinearly sampled colour; pixel centres are at +0.5. Written straight from the definition.
double colour_at(const Image& image, const Vec2f& t, int channel) {
    const double x = std::clamp(t.x * image.width - 0.5, 0.0, image.width - 1.0);
    const double y = std::clamp(t.y * image.height - 0.5, 0.0, image.height - 1.0);
    double sum = 0;
    for (int py = 0; py < image.height; ++py)
        for (int px = 0; px < image.width; ++px) {
            const double wx = std::max(0.0, 1 - std::abs(x - px)), wy = std::max(0.0, 1 - std::abs(y - py));
            sum += wx * wy * image.at(px, py)[image.channels == 1 ? 0 : channel];
        }
    return sum;
}

// The parameter is the number of the texture's channels, 0 = no texture.
class Ply : public ::testing::TestWithParam<int> {};

TEST_P(Ply, ComesBackWithColours) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(24, 18);
    const Image texture = GetParam() ? sample_texture(32, 20, GetParam()) : Image{};
    export_scene({&mesh, GetParam() ? &texture : nullptr, kGenerator, ""}, {}, folder / "a.ply");
    const std::string bytes = contents(folder / "a.ply");
    const std::size_t end = bytes.find("end_header\n") + 11;
    const std::string header = bytes.substr(0, end);
    EXPECT_TRUE(header.starts_with("ply\nformat binary_little_endian 1.0\n"));
    EXPECT_CONTAINS(header, "element vertex 432\n");
    EXPECT_CONTAINS(header, "element face 782\n");
    EXPECT_EQ(header.find("red") != std::string::npos, GetParam() != 0);
    const std::size_t vertex_size = 24 + (GetParam() ? 3 : 0);
    ASSERT_EQ(bytes.size(), end + 432 * vertex_size + 782 * 13);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const char* vertex = bytes.data() + end + i * vertex_size;
        Vec3f position, normal;
        std::memcpy(&position, vertex, 12);
        std::memcpy(&normal, vertex + 12, 12);
        EXPECT_EQ(position, mesh.positions[i]);
        EXPECT_EQ(normal, mesh.normals[i]);
        for (int c = 0; c < (GetParam() ? 3 : 0); ++c)
            EXPECT_NEAR(static_cast<std::uint8_t>(vertex[24 + c]), colour_at(texture, mesh.texcoords[i], c),
                        0.51);
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const char* face = bytes.data() + end + 432 * vertex_size + i * 13;
        EXPECT_EQ(face[0], 3);
        EXPECT_EQ(std::memcmp(face + 1, mesh.triangles[i].data(), 12), 0);
    }
}

INSTANTIATE_TEST_SUITE_P(Channels, Ply, ::testing::Values(0, 1, 3));

class Stl : public ::testing::TestWithParam<StlUnit> {};

TEST_P(Stl, ComesBackInItsUnit) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(24, 18);
    ExportConfig config{.stl_unit = GetParam()};
    const float scale = GetParam() == StlUnit::metre ? 1 : 1000;
    const auto paths = export_scene({&mesh, nullptr, kGenerator, ""}, config, folder / "a.stl");
    EXPECT_EQ(paths.size(), 1u);
    const std::string bytes = contents(paths[0]);
    EXPECT_FALSE(bytes.starts_with("solid"));
    EXPECT_STREQ(bytes.c_str(),
                 ("binary STL, " + std::string(kGenerator) + ", +Y up, camera looking along -Z").c_str());
    std::uint32_t count;
    std::memcpy(&count, bytes.data() + 80, 4);
    ASSERT_EQ(count, mesh.triangles.size());
    ASSERT_EQ(bytes.size(), 84 + 50 * mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        Vec3f read[4];  // the normal, then the corners
        std::memcpy(read, bytes.data() + 84 + 50 * i, 48);
        for (int k = 0; k < 3; ++k) {
            const Vec3f& p = mesh.positions[mesh.triangles[i][k]];
            EXPECT_EQ(read[k + 1], (Vec3f{p.x * scale, p.y * scale, p.z * scale}));
        }
        const Vec3f& normal = mesh.normals[mesh.triangles[i][0]];
        EXPECT_NEAR(std::hypot(read[0].x, read[0].y, read[0].z), 1, 1e-6);
        EXPECT_GT(read[0].x * normal.x + read[0].y * normal.y + read[0].z * normal.z, 0.9);
        EXPECT_EQ(bytes.substr(84 + 50 * i + 48, 2), std::string(2, '\0'));
    }
}

INSTANTIATE_TEST_SUITE_P(Units, Stl, ::testing::Values(StlUnit::metre, StlUnit::millimetre));

TEST(PlyFile, TheLastPropertyOfAVertexTellsWhichCamerasSawIt) {
    const TemporaryFolder folder;
    SurfaceMesh mesh = sample_mesh(4, 3);
    add_provenance(mesh);
    export_scene({&mesh, nullptr, kGenerator, "{}"}, {.normals = NormalsKind::never}, folder / "a.ply");
    const std::string bytes = contents(folder / "a.ply");
    EXPECT_CONTAINS(bytes, "property float z\nproperty uchar provenance\nelement face");
    const std::size_t begin = bytes.find("end_header\n") + 11;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        EXPECT_EQ(bytes.at(begin + 13 * i + 12), static_cast<char>(mesh.provenance[i])) << i;
}

TEST(UpAxis, ZTurnsPositionsAndNormalsAlike) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(4, 4);
    for (const char* name : {"a.obj", "a.ply", "a.stl"})
        export_scene({&mesh, nullptr, kGenerator, ""}, {.up = UpAxis::z}, folder / name);
    const auto turned = [](const Vec3f& v) { return Vec3f{v.x, -v.z, v.y}; };
    const ObjFile obj = read_obj(folder / "a.obj");
    const std::string ply = contents(folder / "a.ply"), stl = contents(folder / "a.stl");
    for (const std::string& text : {contents(folder / "a.obj"), ply})
        EXPECT_CONTAINS(text, "+Z up, camera looking along +Y\n");
    EXPECT_CONTAINS(stl.substr(0, 80), "+Z up, camera looking along +Y");
    ASSERT_EQ(obj.positions.size(), mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        EXPECT_EQ(obj.positions[i], turned(mesh.positions[i]));
        EXPECT_EQ(obj.normals[i], turned(mesh.normals[i]));
        Vec3f vertex[2];
        std::memcpy(vertex, ply.data() + ply.find("end_header\n") + 11 + 24 * i, 24);
        EXPECT_EQ(vertex[0], turned(mesh.positions[i]));
        EXPECT_EQ(vertex[1], turned(mesh.normals[i]));
    }
    Vec3f corner;
    std::memcpy(&corner, stl.data() + 84 + 12, 12);
    EXPECT_EQ(corner, turned(mesh.positions[mesh.triangles[0][0]]));
}

TEST(PlyFile, HasTextureCoordinatesOnRequest) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(4, 4);
    ExportConfig config{.normals = NormalsKind::never, .ply_texcoords = true};
    export_scene({&mesh, nullptr, kGenerator, ""}, config, folder / "a.ply");
    const std::string bytes = contents(folder / "a.ply");
    const std::size_t begin = bytes.find("property float s\nproperty float t\nelement face");
    ASSERT_NE(begin, std::string::npos);
    for (std::size_t i = 0; i < mesh.texcoords.size(); ++i) {
        Vec2f st;
        std::memcpy(&st, bytes.data() + bytes.find("end_header\n") + 11 + 20 * i + 12, 8);
        EXPECT_EQ(st, (Vec2f{mesh.texcoords[i].x, 1 - mesh.texcoords[i].y})) << i;
    }
}

TEST(PlyFile, WithoutNormals) {
    const TemporaryFolder folder;
    SurfaceMesh mesh = sample_mesh(4, 4);
    mesh.normals.clear();
    export_scene({&mesh, nullptr, kGenerator, ""}, {}, folder / "a.ply");
    EXPECT_EQ(contents(folder / "a.ply").find("property float nx"), std::string::npos);
}

}  // namespace
}  // namespace hexrelief::exporters
