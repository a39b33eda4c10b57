// Tests that describe_mesh() returns or throws an Error that names the file, whatever the file holds.
#include <sys/resource.h>

#include <sys/stat.h>

#include <csignal>
#include <functional>
#include <new>
#include <random>

#include "exporters/inspect/describe_mesh.h"
#include "exporters/inspect/limited.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::inspect {
namespace {

void expect_input_error(const std::filesystem::path& path, const std::string& what) {
    EXPECT_CONTAINS(test::error_of([&] { exporters::describe_mesh(path); }), path.string()) << what;
}

class Malformed : public ::testing::TestWithParam<const exporters::MeshFormat*> {
  protected:
    std::string written() {
        const SurfaceMesh mesh = exporters::sample_mesh(12, 9);
        const Image texture = exporters::sample_texture(16, 16);
        exporters::ExportConfig config;
        exporters::export_scene({&mesh, &texture, exporters::kGenerator, "{}"}, config, path_);
        return exporters::contents(path_);
    }
    exporters::TemporaryFolder folder_;
    std::filesystem::path path_ = folder_ / (std::string("a") + GetParam()->extension);
};

TEST_P(Malformed, MissingEmptyFolderAndOtherContents) {
    expect_input_error(path_, "a missing file");
    exporters::put(path_, "");
    expect_input_error(path_, "an empty file");
    exporters::put(path_, "hello\n");
    expect_input_error(path_, "a text");
    exporters::put(path_, std::string(1000, '\0'));
    expect_input_error(path_, "zeros");
    exporters::put(path_, std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16));
    expect_input_error(path_, "a PNG");
    std::filesystem::remove(path_);
    std::filesystem::create_directory(path_);
    expect_input_error(path_, "a folder");
}

TEST_P(Malformed, Truncated) {
    const std::string bytes = written();
    ASSERT_NO_THROW(exporters::describe_mesh(path_));
    for (const double share : {0.01, 0.1, 0.3, 0.5, 0.7, 0.9}) {
        exporters::put(path_, bytes.substr(0, static_cast<std::size_t>(bytes.size() * share)));
        // An OBJ cut between two lines is a valid shorter OBJ; only the number of its faces differs.
        if (path_.extension() == ".obj")
            test::refusal_of([&] { EXPECT_LT(exporters::describe_mesh(path_).triangles, 176); });
        else
            expect_input_error(path_, "a file cut at " + std::to_string(share));
    }
}

TEST_P(Malformed, RandomBytesChanged) {
    const std::string bytes = written();
    std::mt19937 random(7);
    for (int round = 0; round < 200; ++round) {
        std::string broken = bytes;
        const std::size_t reach = round % 2 ? std::min<std::size_t>(200, bytes.size()) : bytes.size();
        for (int i = 0; i <= round % 4; ++i) broken[random() % reach] = static_cast<char>(random());
        exporters::put(path_, broken);
        test::refusal_of([&] { exporters::describe_mesh(path_); });
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, Malformed, ::testing::ValuesIn(exporters::formats_of_files()),
                         [](const auto& instance) { return instance.param->name(); });

TEST(MalformedFile, HugeClaims) {
    const exporters::TemporaryFolder folder;
    exporters::put(
        folder / "a.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 9000000000000000000\nproperty float x\n"
        "end_header\nxxxxxxxxxxxxxxxx");
    expect_input_error(folder / "a.ply", "a huge vertex count");
    exporters::put(folder / "b.ply",
                   "ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n1 2 3\n");
    expect_input_error(folder / "b.ply", "items without properties");
    exporters::put(
        folder / "c.ply",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty list int int x\nend_header\n4e18 2 3\n");
    expect_input_error(folder / "c.ply", "a huge list");
    exporters::put(folder / "a.gltf",
                   R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":9000000000000000}]})");
    expect_input_error(folder / "a.gltf", "a huge buffer");
    exporters::put(
        folder / "b.gltf",
        R"({"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":9}}]}]})");
    expect_input_error(folder / "b.gltf", "a missing accessor");
    exporters::put(folder / "c.gltf", R"({"asset":{"version":"2.0"},"meshes":[{"primitives":7}]})");
    expect_input_error(folder / "c.gltf", "primitives that are a number");
    exporters::put(folder / "d.gltf", R"({"asset":{"version":"1.0"}})");
    expect_input_error(folder / "d.gltf", "version 1");
    exporters::put(folder / "e.gltf", std::string(200000, '['));
    expect_input_error(folder / "e.gltf", "deep nesting");
    exporters::put(folder / "f.gltf", std::string(R"({"asset":{"version":"2.0"},"x":)") +
                                          std::string(100000, '[') + std::string(100000, ']') + "}");
    expect_input_error(folder / "f.gltf", "deep nesting that nobody reads");
    std::string chain;
    for (int i = 1; i < 50000; ++i) chain += R"({"children":[)" + std::to_string(i) + "]},";
    exporters::put(folder / "g.gltf",
                   R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[)" + chain + "{}]}");
    EXPECT_EQ(exporters::describe_mesh(folder / "g.gltf").vertices, 0) << "a chain of nodes";
    std::ofstream(folder / "huge.obj").close();
    std::filesystem::resize_file(folder / "huge.obj", std::uintmax_t{3} << 30);  // a sparse file
    expect_input_error(folder / "huge.obj", "3 GiB");
}

TEST(MalformedFile, ObjNumbersAndIndices) {
    const exporters::TemporaryFolder folder;
    for (const char* text : {"v 1 2\n", "v 1 2 x\n", "v 1 2 nan\n", "v 0 0 0\nf 1 1 2\n", "v 0 0 0\nf 1 1\n",
                             "v 0 0 0\nf 0 1 1\n", "v 0 0 0\nf -2 1 1\n",
                             "v 0 0 0\nf -9223372036854775808 1 1\n", "f 1 2 3\n", "v 1 2 3 4 5 6 7 8\n"}) {
        exporters::put(folder / "a.obj", text);
        expect_input_error(folder / "a.obj", text);
    }
}

TEST(MalformedFile, ObjLibrariesThatAreNoFiles) {
    const exporters::TemporaryFolder folder;
    ASSERT_EQ(mkfifo((folder / "pipe.mtl").c_str(), 0600), 0);  // opening it would block for ever
    exporters::put(folder / "a.obj", "mtllib pipe.mtl\nmtllib /dev/zero\nv 0 0 0\n");
    EXPECT_EQ(exporters::describe_mesh(folder / "a.obj").texture_bytes, 0);
}

TEST(MalformedFile, MissingBufferFile) {
    const exporters::TemporaryFolder folder;
    const SurfaceMesh mesh = exporters::sample_mesh(4, 4);
    const auto paths =
        exporters::export_scene({&mesh, nullptr, exporters::kGenerator, ""}, {}, folder / "a.gltf");
    std::filesystem::remove(paths.at(1));
    expect_input_error(paths[0], "a missing .bin");
}

// There are too many primitives in too many places to examine each box.
TEST(DescribeGltf, ManyPrimitivesInManyPlaces) {
    std::string nodes, roots, primitives;
    for (int i = 0; i < 20000; ++i) {
        nodes += R"({"mesh":0},)";
        roots += std::to_string(i) + ",";
    }
    for (int i = 0; i < 5000; ++i) primitives += R"({"attributes":{"POSITION":0}},)";
    for (std::string* list : {&nodes, &roots, &primitives}) list->pop_back();
    const exporters::TemporaryFolder folder;
    exporters::put(folder / "a.gltf",
                   R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[)" + roots + R"(]}],"nodes":[)" + nodes +
                       R"(],"meshes":[{"primitives":[)" + primitives +
                       R"(]}],"accessors":[{"componentType":5126,"type":"VEC3","count":3,)" +
                       R"("min":[0,0,0],"max":[1,2,3]}]})");
    const MeshDescription mesh = exporters::describe_mesh(folder / "a.gltf");
    EXPECT_EQ(mesh.vertices, 15000);
    EXPECT_EQ(mesh.max, (Vec3f{1, 2, 3}));
}

std::string word(std::uint32_t value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

// The length that such a file states for its JSON cannot be compared with the header's.
TEST(MalformedFile, AGlbShorterThanItsHeader) {
    const exporters::TemporaryFolder folder;
    for (const std::uint32_t length : {0u, 12u, 19u}) {
        exporters::put(folder / "a.glb",
                       "glTF" + word(2) + word(length) + word(3000000000u) + "JSON{\"a\":\"");
        expect_input_error(folder / "a.glb", "a length of " + std::to_string(length));
    }
}

TEST(Describe, TheBufferOfAGlbIsNotRead) {
    const exporters::TemporaryFolder folder;
    const std::string json = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":3000000000}]} )";
    const auto head = static_cast<std::uint32_t>(12 + 8 + json.size() + 8);
    exporters::put(folder / "a.glb", "glTF" + word(2) + word(head + 3000000000u) +
                                         word(static_cast<std::uint32_t>(json.size())) + "JSON" + json +
                                         word(3000000000u) + std::string("BIN\0", 4));
    expect_input_error(folder / "a.glb", "a missing buffer");
    std::filesystem::resize_file(folder / "a.glb",
                                 std::uintmax_t{head} + 3000000000u);  // more than is ever read
    EXPECT_EQ(exporters::describe_mesh(folder / "a.glb").vertices, 0);
}

std::string refusal(const WorkLimits& limits, const std::function<WorkBytes()>& work) {
    return test::error_of([&] { run_limited(limits, "cannot: ", work); });
}

TEST(Limited, ResultsAndErrorsComeBack) {
    const WorkLimits limits{5, std::uint64_t{1} << 30, 1000};
    EXPECT_EQ(run_limited(limits, "", [] { return WorkBytes{1, 2, 3}; }), (WorkBytes{1, 2, 3}));
    EXPECT_EQ(run_limited(limits, "", [] { return WorkBytes{}; }), WorkBytes{});
    EXPECT_EQ(refusal(limits, []() -> WorkBytes { throw Error(ErrorKind::input, "it is bad"); }),
              "it is bad");
}

TEST(Limited, WorkIsNotDoneInThisProcess) {
    rlimit before{};
    getrlimit(RLIMIT_NOFILE, &before);
    rlimit none = before;
    none.rlim_cur = 0;
    setrlimit(RLIMIT_NOFILE, &none);  // no pipe to another process
    const std::string told = refusal({5, 1000000, 1000}, []() -> WorkBytes { return {1}; });
    setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_CONTAINS(told, "a process of its own");
}

TEST(Limited, WildWorkEndsAlone) {
    EXPECT_CONTAINS(refusal({5, 1u << 30, 10}, []() -> WorkBytes { throw std::bad_alloc(); }), "memory");
    EXPECT_CONTAINS(refusal({5, 1u << 30, 10},
                            []() -> WorkBytes {
                                raise(SIGKILL);
                                return {};
                            }),
                    "crashes");
    EXPECT_CONTAINS(refusal({1, 1u << 30, 10},
                            []() -> WorkBytes {
                                raise(SIGXCPU);  // as the kernel does when the time is up
                                return {};
                            }),
                    "more than 1 s");
}

}  // namespace
}  // namespace hexrelief::inspect
