#include "exporters/inspect/describe_mesh.h"

#include "tests/exporters/sample_scene.h"

namespace hexrelief::inspect {
namespace {

struct Case {
    const char* name;
    bool draco, textured;
};

class Describe : public ::testing::TestWithParam<Case> {};

TEST_P(Describe, TellsWhatWasWritten) {
    const auto& [name, draco, textured] = GetParam();
    const exporters::TemporaryFolder folder;
    const SurfaceMesh mesh = exporters::sample_mesh(24, 18);
    const Image texture = exporters::sample_texture(64, 48);
    exporters::ExportConfig config{.normals = exporters::NormalsKind::always,
                                   .origin = exporters::FileOrigin::camera};
    if (draco) config.compression = exporters::Compression::draco;
    const auto paths = exporters::export_scene(
        {&mesh, textured ? &texture : nullptr, exporters::kGenerator, "{}"}, config, folder / name);
    const MeshDescription out = exporters::describe_mesh(paths[0]);
    const std::string format = paths[0].extension().string().substr(1);
    EXPECT_EQ(out.format, format);
    EXPECT_EQ(out.vertices, 432);
    EXPECT_EQ(out.triangles, 782);
    const bool is_bare = format == "stl";
    EXPECT_EQ(out.normals, !is_bare && format != "3mf");
    EXPECT_EQ(out.texcoords, textured && format != "ply" && !is_bare);
    EXPECT_EQ(out.colors, textured && format == "ply");
    EXPECT_EQ(out.compression, draco || format == "drc" ? "draco" : "none");
    EXPECT_EQ(out.texture_bytes > 0, textured && format != "ply" && format != "drc" && !is_bare);
    EXPECT_EQ(out.generator, format == "drc" ? "" : exporters::kGenerator);
    ASSERT_TRUE(out.has_bounds);
    const float tolerance = out.compression == "draco" ? 2.f / 4095 : 0;
    const float scale = format == "3mf" ? 1000 : 1;  // whose numbers are mm
    EXPECT_NEAR(out.min.x, -scale, tolerance);
    EXPECT_NEAR(out.max.x, scale, tolerance);
    EXPECT_NEAR(out.min.y, -0.5f * scale, tolerance);
    EXPECT_NEAR(out.max.y, 0.5f * scale, tolerance);
    EXPECT_LT(out.max.z, -1.6f * scale);
    if (paths.size() == 3) {
        EXPECT_EQ(out.texture_bytes, static_cast<long long>(std::filesystem::file_size(paths[2])));
    }
}

INSTANTIATE_TEST_SUITE_P(Files, Describe,
                         ::testing::Values(Case{"a.glb", false, true}, Case{"a.glb", true, true},
                                           Case{"a.glb", true, false}, Case{"two words.gltf", false, true},
                                           Case{"a.gltf", true, false}, Case{"a.drc", false, true},
                                           Case{"a.drc", false, false}, Case{"two words.obj", false, true},
                                           Case{"a.obj", false, false}, Case{"a.ply", false, true},
                                           Case{"a.ply", false, false}, Case{"a.stl", false, true},
                                           Case{"a.3mf", false, true}, Case{"a.3mf", false, false},
                                           Case{"a.usdz", false, true}, Case{"a.usdz", false, false}),
                         [](const auto& instance) { return std::to_string(instance.index); });

TEST(Describe, TellsWhichCamerasSawTheVertices) {
    using exporters::Compression;
    const exporters::TemporaryFolder folder;
    SurfaceMesh mesh = exporters::sample_mesh(24, 18);
    const decltype(MeshDescription::provenance) none = {}, wanted = {216, 72, 72, 71, 1};
    for (const auto compression : {Compression::none, Compression::quantized, Compression::meshopt})
        for (const char* const name : {"a.glb", "a.ply"}) {
            exporters::ExportConfig config{.compression = compression};
            mesh.provenance.clear();
            exporters::export_scene({&mesh, nullptr, exporters::kGenerator, "{}"}, config, folder / name);
            EXPECT_EQ(exporters::describe_mesh(folder / name).provenance, none) << name;
            exporters::add_provenance(mesh);
            *std::find(mesh.provenance.begin(), mesh.provenance.end(), Provenance::nobody) =
                Provenance::filled;
            exporters::export_scene({&mesh, nullptr, exporters::kGenerator, "{}"}, config, folder / name);
            EXPECT_EQ(exporters::describe_mesh(folder / name).provenance, wanted) << name;
        }
}

TEST(DescribeObj, PolygonsRelativeIndicesAndColours) {
    const exporters::TemporaryFolder folder;
    exporters::put(
        folder / "a.obj",
        "v 0 0 0 1 0 0\r\nv +1 0 0 1 0 0\r\nv 1 1 0 1 0 0\r\nv 0 1e0 -2.5 1 0 0\r\nf -4 -3 -2 -1\r\nf 1 2 3");
    const MeshDescription out = exporters::describe_mesh(folder / "a.obj");
    EXPECT_EQ(out.vertices, 4);
    EXPECT_EQ(out.triangles, 3);
    EXPECT_TRUE(out.colors);
    EXPECT_FALSE(out.normals);
    EXPECT_EQ(out.min, (Vec3f{0, 0, -2.5f}));
}

TEST(DescribePly, AsciiWithStrangeElements) {
    const exporters::TemporaryFolder folder;
    exporters::put(
        folder / "a.ply",
        "ply\nformat ascii 1.0\nobj_info x\nelement camera 1\nproperty list uchar float view\nelement vertex "
        "3\n"
        "property double x\nproperty double y\nproperty double z\nproperty uchar red\nelement face 1\n"
        "property list uchar int vertex_index\nend_header\n2 0.5 0.25\n0 0 0 9\n1 0 0 9\n0 1 -3 9\n3 0 1 "
        "2\n");
    const MeshDescription out = exporters::describe_mesh(folder / "a.ply");
    EXPECT_EQ(out.vertices, 3);
    EXPECT_EQ(out.triangles, 1);
    EXPECT_TRUE(out.colors);
    EXPECT_EQ(out.min, (Vec3f{0, 0, -3}));
}

TEST(DescribePly, BigEndian) {
    const exporters::TemporaryFolder folder;
    std::string text =
        "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
        "float z\n"
        "end_header\n";
    text += std::string("\x3f\x80\x00\x00\x40\x00\x00\x00\xbf\x80\x00\x00", 12);  // 1, 2, -1
    exporters::put(folder / "a.ply", text);
    EXPECT_EQ(exporters::describe_mesh(folder / "a.ply").max, (Vec3f{1, 2, -1}));
}

}  // namespace
}  // namespace hexrelief::inspect
