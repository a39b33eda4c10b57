#include <cerrno>
#include <cstring>
#include <functional>
#include <map>
#include <stdexcept>

#include "exporters/inspect/describe_mesh.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

namespace fs = std::filesystem;

ErrorKind kind_of(const std::function<void()>& call, std::string& message) {
    try {
        call();
    } catch (const Error& error) {
        message = error.what();
        return error.kind();
    }
    ADD_FAILURE() << "no Error";
    return ErrorKind::usage;
}

TEST(Exporter, ChoosesFormatByExtensionInAnyCase) {
    EXPECT_EQ(export_format("a/b.glb"), MeshFormat::glb);
    EXPECT_EQ(export_format("b.GLTF"), MeshFormat::gltf);
    EXPECT_EQ(export_format("b.x.Drc"), MeshFormat::drc);
    EXPECT_EQ(export_format("b.obj"), MeshFormat::obj);
    EXPECT_EQ(export_format("b.ply"), MeshFormat::ply);
    EXPECT_EQ(export_format("b.stl"), MeshFormat::stl);
    const std::vector<std::string> all = {".glb", ".gltf", ".drc", ".obj", ".ply", ".stl", ".usdz", ".html"};
    EXPECT_EQ(export_extensions(), all);
    for (const std::string& extension : all)
        EXPECT_EQ("." + format_name(export_format("a" + extension)), extension);
}

// Every extension has its own writer and description: each file is recognised as its format.
TEST(Exporter, EveryFormatIsWrittenAndDescribedAsItself) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(6, 5);
    const std::map<std::string, std::string> begins = {
        {".glb", "glTF"},  {".gltf", "{"},         {".drc", "DRACO"},  {".obj", "# "},
        {".ply", "ply\n"}, {".stl", "binary STL"}, {".usdz", "PK\3\4"}};
    for (const std::string& extension : export_extensions()) {
        if (extension == ".html") continue;  // needs more than the other formats: viewer/html_test.cpp
        const fs::path path = folder / ("a" + extension);
        export_scene({&mesh, nullptr, kGenerator, "{}"}, {}, path);
        std::ifstream file(path, std::ios::binary);
        std::string begin(begins.at(extension).size(), ' ');
        file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
        EXPECT_EQ(begin, begins.at(extension)) << extension;
        const inspect::MeshDescription described = inspect::describe_mesh(path);
        EXPECT_EQ("." + described.format, extension);
        EXPECT_EQ(described.vertices, 30) << extension;
    }
}

TEST(Exporter, UnknownExtensionIsUsageErrorThatListsAll) {
    for (const char* path : {"a.off", "a", "a.", ".glb", "a.glb/"}) {
        std::string message;
        EXPECT_EQ(kind_of([&] { export_format(path); }, message), ErrorKind::usage) << path;
        for (const std::string& extension : export_extensions()) {
            EXPECT_NE(message.find(extension), std::string::npos) << message;
        }
    }
}

TEST(Exporter, EmptyMeshIsInputErrorAndWritesNothing) {
    const TemporaryFolder folder;
    const SurfaceMesh mesh;
    std::string message;
    EXPECT_EQ(kind_of(
                  [&] {
                      export_scene({&mesh, nullptr, "", ""}, {}, folder / "a.glb");
                  },
                  message),
              ErrorKind::input);
    EXPECT_EQ(folder.entries(), 0);
}

TEST(Exporter, BrokenMeshIsBug) {
    const TemporaryFolder folder;
    SurfaceMesh outside = sample_mesh(4, 4), short_normals = outside, nan = outside;
    outside.triangles[3][1] = 16;
    short_normals.normals.pop_back();
    nan.positions[2].y = std::nanf("");
    for (const SurfaceMesh* mesh : {&outside, &short_normals, &nan}) {
        EXPECT_THROW(export_scene({mesh, nullptr, "", ""}, {}, folder / "a.glb"), std::logic_error);
    }
    const SurfaceMesh sound = sample_mesh(4, 4);
    EXPECT_THROW(export_scene({&sound, nullptr, "", "[1]"}, {}, folder / "a.glb"), std::logic_error);
    EXPECT_EQ(folder.entries(), 0);
}

class EveryFormat : public ::testing::TestWithParam<const char*> {
  protected:
    const SurfaceMesh mesh_ = sample_mesh(24, 18);
    const Image texture_ = sample_texture(64, 48);
    const Scene scene_{&mesh_, &texture_, kGenerator, "{}"};
    const TemporaryFolder folder_;
    const std::string name_ = std::string("relief") + GetParam();
};

TEST_P(EveryFormat, ReturnsAllFilesPathFirst) {
    const auto paths = export_scene(scene_, {}, folder_ / name_);
    ASSERT_FALSE(paths.empty());
    EXPECT_EQ(paths[0], folder_ / name_);
    for (const fs::path& path : paths) EXPECT_GT(fs::file_size(path), 0u) << path;
    EXPECT_EQ(folder_.entries(), static_cast<std::ptrdiff_t>(paths.size()));
    const bool many = name_.ends_with(".gltf") || name_.ends_with(".obj");
    EXPECT_EQ(paths.size(), many ? 3u : 1u);
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
    std::string message;
    const fs::path path = folder_ / "missing" / name_;
    EXPECT_EQ(kind_of([&] { export_scene(scene_, {}, path); }, message), ErrorKind::output);
    EXPECT_NE(message.find(path.string()), std::string::npos) << message;
    EXPECT_NE(message.find(std::strerror(ENOENT)), std::string::npos) << message;
    EXPECT_EQ(folder_.entries(), 0);
}

TEST_P(EveryFormat, FullDeviceIsOutputErrorAndLeavesNothing) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    fs::create_symlink("/dev/full", folder_ / name_);
    std::string message;
    EXPECT_EQ(kind_of([&] { export_scene(scene_, {}, folder_ / name_); }, message), ErrorKind::output);
    EXPECT_NE(message.find(std::strerror(ENOSPC)), std::string::npos) << message;
    EXPECT_EQ(folder_.entries(), 1);  // the link
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_P(EveryFormat, FailureOfTheLastFileLeavesNone) {
    const auto paths = export_scene(scene_, {}, folder_ / name_);
    for (const fs::path& path : paths) fs::remove(path);
    fs::create_directory(paths.back());  // a folder with the name of the last file
    std::string message;
    EXPECT_EQ(kind_of([&] { export_scene(scene_, {}, folder_ / name_); }, message), ErrorKind::output);
    EXPECT_NE(message.find(paths.back().string()), std::string::npos) << message;
    EXPECT_EQ(folder_.entries(), 1);
}

INSTANTIATE_TEST_SUITE_P(Exporter, EveryFormat,
                         ::testing::Values(".glb", ".gltf", ".drc", ".obj", ".ply", ".stl", ".usdz"),
                         [](const auto& instance) { return std::string(instance.param + 1); });

}  // namespace
}  // namespace hexrelief::exporters
