#include <cerrno>
#include <cstring>
#include <map>
#include <stdexcept>

#include "exporters/inspect/describe_mesh.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

namespace fs = std::filesystem;

TEST(Exporter, ChoosesFormatByExtensionInAnyCase) {
    for (const auto& [path, name] : std::map<std::string, std::string>{{"a/b.glb", "glb"},
                                                                       {"b.GLTF", "gltf"},
                                                                       {"b.x.Drc", "drc"},
                                                                       {"b.obj", "obj"},
                                                                       {"b.ply", "ply"},
                                                                       {"b.stl", "stl"}})
        EXPECT_EQ(export_format(path).name(), name);
    for (const MeshFormat* format : mesh_formats())
        EXPECT_EQ(&export_format("a" + std::string(format->extension)), format);
}

// Between the heading and the next one, in the order of the rows.
TEST(Exporter, FormatsMdHasTheRowsOfAllFormats) {
    std::string rows;
    for (const MeshFormat* format : mesh_formats())
        rows += "| `" + std::string(format->extension) + "` | " + format->holds + " |\n";
    const std::string page = contents(HEXRELIEF_SOURCE_DIR "/exporters/FORMATS.md");
    const std::size_t begin = page.find("| --- | --- |\n", page.find("## Files written"));
    ASSERT_NE(begin, std::string::npos);
    const std::size_t first = begin + 14;
    EXPECT_EQ(page.substr(first, page.find("\n\n", first) + 1 - first), rows)
        << "write FORMATS.md anew as this:\n"
        << rows;
}

TEST(Exporter, TheOriginMayBeAtTheBaseOfTheMesh) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(6, 5);
    const Image texture = sample_texture(8, 8);
    const Calibration camera = sample_camera();
    Scene scene{&mesh, &texture, "test", ""};
    scene.camera = &camera;
    ExportConfig config{.origin = FileOrigin::base, .copyright = "a photographer"};
    for (const char* const name : {"a.glb", "a.gltf", "a.obj", "a.ply", "a.usdz"}) {
        export_scene(scene, config, folder / name);
        const inspect::MeshDescription file = describe_mesh(folder / name);
        EXPECT_NEAR(file.min.y, 0, 1e-3) << name;
        EXPECT_NEAR(file.min.x + file.max.x, 0, 2e-3) << name;
        EXPECT_NEAR(file.min.z + file.max.z, 0, 2e-3) << name;
        EXPECT_NEAR(file.max.y, 1, 1e-3) << name;
    }
    EXPECT_CONTAINS(contents(folder / "a.gltf"), "a photographer");
    config.origin = FileOrigin::automatic;
    for (const auto& [name, low] : {std::pair{"b.glb", -0.5f}, {"b.usdz", 0.0f}}) {
        export_scene(scene, config, folder / name);
        EXPECT_NEAR(describe_mesh(folder / name).min.y, low, 1e-3) << name;
    }
}

// Every extension has its own writer and description: each file is recognised as its format.
TEST(Exporter, EveryFormatIsWrittenAndDescribedAsItself) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(6, 5);
    const std::map<std::string, std::string> begins = {
        {".glb", "glTF"},  {".gltf", "{"},         {".drc", "DRACO"},  {".obj", "# "},
        {".ply", "ply\n"}, {".stl", "binary STL"}, {".3mf", "PK\3\4"}, {".usdz", "PK\3\4"}};
    for (const MeshFormat* format : mesh_formats()) {
        if (format->is_page) continue;  // needs more than the other formats: viewer/html_test.cpp
        const std::string extension = format->extension;
        const fs::path path = folder / ("a" + extension);
        export_scene({&mesh, nullptr, kGenerator, "{}"}, {}, path);
        if (const auto begin = begins.find(extension); begin != begins.end()) {
            EXPECT_TRUE(contents(path).starts_with(begin->second)) << extension;
        }
        const inspect::MeshDescription described = describe_mesh(path);
        EXPECT_EQ("." + described.format, extension);
        EXPECT_EQ(described.vertices, 30) << extension;
    }
}

TEST(Exporter, UnknownExtensionIsUsageErrorThatListsAll) {
    for (const char* path : {"a.none", "a", "a.", ".glb", "a.glb/"})
        EXPECT_CONTAINS(test::error_of([&] { export_format(path); }, ErrorKind::usage),
                        "use one of " + export_extensions());
}

TEST(Exporter, EmptyMeshIsInputErrorAndWritesNothing) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh;
    test::error_of([&] { export_scene({&mesh, nullptr, "", ""}, {}, folder / "a.glb"); });
    EXPECT_EQ(folder.entries(), 0);
}

TEST(Exporter, BrokenMeshIsBug) {
    const TemporaryFolder folder;
    SurfaceMesh outside = sample_mesh(4, 4), short_normals = outside, nan = outside;
    outside.triangles[3][1] = 16;
    short_normals.normals.pop_back();
    nan.positions[2].y = std::nanf("");
    for (const SurfaceMesh* mesh : {&outside, &short_normals, &nan})
        EXPECT_THROW(export_scene({mesh, nullptr, "", ""}, {}, folder / "a.glb"), std::logic_error);
    const SurfaceMesh sound = sample_mesh(4, 4);
    EXPECT_THROW(export_scene({&sound, nullptr, "", "[1]"}, {}, folder / "a.glb"), std::logic_error);
    EXPECT_EQ(folder.entries(), 0);
}

class EveryFormat : public ::testing::TestWithParam<const MeshFormat*> {
  protected:
    const SurfaceMesh mesh_ = sample_mesh(24, 18);
    const Image texture_ = sample_texture(64, 48);
    const Scene scene_{&mesh_, &texture_, kGenerator, "{}"};
    const TemporaryFolder folder_;
    const std::string name_ = std::string("relief") + GetParam()->extension;
};

TEST_P(EveryFormat, ReturnsAllFilesPathFirst) {
    const auto paths = export_scene(scene_, {}, folder_ / name_);
    ASSERT_FALSE(paths.empty());
    EXPECT_EQ(paths[0], folder_ / name_);
    for (const fs::path& path : paths) EXPECT_GT(fs::file_size(path), 0u) << path;
    EXPECT_EQ(folder_.entries(), static_cast<std::ptrdiff_t>(paths.size()));
    EXPECT_EQ(paths.size(), GetParam()->companion ? 3u : 1u);
}

TEST_P(EveryFormat, HoldsTheMeshUpright) {
    SurfaceMesh turned = mesh_;  // by a quarter: what was up points to +X
    for (std::vector<Vec3f>* vectors : {&turned.positions, &turned.normals})
        for (Vec3f& v : *vectors) v = {v.y, -v.x, v.z};
    Scene lying = scene_;
    lying.mesh = &turned;
    lying.up = {1, 0};
    const auto size_of = [&](const Scene& scene) {
        export_scene(scene, {}, folder_ / name_);
        const inspect::MeshDescription found = describe_mesh(folder_ / name_);
        return std::pair{found.max.x - found.min.x, found.max.y - found.min.y};
    };
    const auto upright = size_of(scene_), stood_up = size_of(lying);
    EXPECT_NEAR(stood_up.first, upright.first, 1e-3);
    EXPECT_NEAR(stood_up.second, upright.second, 1e-3);
}

TEST_P(EveryFormat, SameBytesTwice) {
    for (const bool draco : {false, true}) {
        ExportConfig config;
        if (draco) config.compression = Compression::draco;
        std::vector<std::string> first;
        for (const fs::path& path : export_scene(scene_, config, folder_ / name_))
            first.push_back(contents(path));
        std::vector<std::string> second;
        for (const fs::path& path : export_scene(scene_, config, folder_ / name_))
            second.push_back(contents(path));
        EXPECT_EQ(first, second);
    }
}

TEST_P(EveryFormat, MissingFolderIsOutputErrorWithPathAndReason) {
    const fs::path path = folder_ / "missing" / name_;
    const std::string message = test::error_of([&] { export_scene(scene_, {}, path); }, ErrorKind::output);
    EXPECT_CONTAINS(message, path.string());
    EXPECT_CONTAINS(message, std::strerror(ENOENT));
    EXPECT_EQ(folder_.entries(), 0);
}

TEST_P(EveryFormat, FullDeviceIsOutputErrorAndLeavesNothing) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    fs::create_symlink("/dev/full", folder_ / name_);
    EXPECT_CONTAINS(test::error_of([&] { export_scene(scene_, {}, folder_ / name_); }, ErrorKind::output),
                    std::strerror(ENOSPC));
    EXPECT_EQ(folder_.entries(), 1);  // the link
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_P(EveryFormat, FailureOfTheLastFileLeavesNone) {
    const auto paths = export_scene(scene_, {}, folder_ / name_);
    for (const fs::path& path : paths) fs::remove(path);
    fs::create_directory(paths.back());  // a folder with the name of the last file
    EXPECT_CONTAINS(test::error_of([&] { export_scene(scene_, {}, folder_ / name_); }, ErrorKind::output),
                    paths.back().string());
    EXPECT_EQ(folder_.entries(), 1);
}

INSTANTIATE_TEST_SUITE_P(Exporter, EveryFormat, ::testing::ValuesIn(formats_of_files()),
                         [](const auto& instance) { return instance.param->name(); });

}  // namespace
}  // namespace hexrelief::exporters
