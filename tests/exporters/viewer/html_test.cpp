#include "exporters/viewer/html_exporter.h"

#include <stdexcept>

#include "exporters/inspect/describe_mesh.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

constexpr std::size_t kMostWithoutMesh = 700'000;  // bytes

TEST(HtmlText, Base64OfEveryLength) {
    EXPECT_EQ(base64({}), "");
    EXPECT_EQ(base64({'f'}), "Zg==");
    EXPECT_EQ(base64({'f', 'o'}), "Zm8=");
    EXPECT_EQ(base64({'f', 'o', 'o'}), "Zm9v");
    EXPECT_EQ(base64({255, 254, 253, 0}), "//79AA==");
}

TEST(HtmlText, TextStaysText) {
    EXPECT_EQ(html_escaped("<b a=\"x\" c='y'>&"), "&lt;b a=&quot;x&quot; c=&#39;y&#39;&gt;&amp;");
    EXPECT_EQ(script_escaped(R"({"a": "</script><!--"})"), R"({"a": "\u003c/script>\u003c!--"})");
}

TEST(HtmlText, MarksInValuesAreNotFilled) {
    EXPECT_EQ(filled("a @x@ b @y@ c", {{"@x@", "@y@"}, {"@y@", "2"}}), "a @y@ b 2 c");
    EXPECT_THROW(filled("a", {{"@x@", ""}}), std::logic_error);
}

class Page : public ::testing::Test {
  protected:
    void SetUp() override {
        if (!has_viewer()) GTEST_SKIP() << kNoViewer;
        scene_.camera = &camera_;
        scene_.image_width = 64;
        scene_.image_height = 48;
    }
    TemporaryFolder folder_;
    const SurfaceMesh mesh_ = sample_mesh(24, 18), half_ = sample_mesh(12, 9);
    const Image texture_ = sample_texture(64, 48);
    const Calibration camera_ = sample_camera();
    Scene scene_{&mesh_, &texture_, kGenerator, "{}"};
};

TEST_F(Page, HoldsTheMeshInAllLevels) {
    scene_.coarser = {&half_};
    const auto path = folder_ / "a.html";
    ExportConfig config;
    config.compression = Compression::draco;   // the page itself uses meshopt
    config.lod_storage = LevelStorage::files;  // the page itself holds all levels
    EXPECT_EQ(export_scene(scene_, config, path).size(), 1u);
    const inspect::MeshDescription seen = describe_mesh(path);
    EXPECT_EQ(seen.format, "html");
    EXPECT_EQ(seen.compression, "meshopt");
    EXPECT_EQ(seen.vertices, static_cast<long long>(mesh_.positions.size()));
    EXPECT_GT(seen.texture_bytes, 0);
    EXPECT_CONTAINS(contents(path), R"({"vertices":108,"triangles":176})");
    EXPECT_EQ(export_size(scene_, config, path), std::filesystem::file_size(path));
}

TEST_F(Page, NamesAndTextsAreEscaped) {
    PageContent content{.pictures = {{"relief", "</script>label", texture_}},
                        .figures = {{"</script><script>figure", 1, 2, "a<b"}}};
    scene_.page = &content;
    const auto path = folder_ / "x<script>y&z.html";
    export_scene(scene_, {}, path);
    const std::string page = contents(path);
    EXPECT_CONTAINS(page, "<title>x&lt;script&gt;y&amp;z</title>");
    for (const char* text : {"x<script>", "<script>figure", "</script>label", "a<b"})
        EXPECT_EQ(page.find(text), std::string::npos) << text;
}

TEST_F(Page, IsSmallWithoutItsMesh) {
    // Noise compresses worst.
    Image noise = sample_texture(130, 130);
    std::uint32_t state = 1;
    for (std::uint8_t& sample : noise.pixels)
        sample = static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
    PageContent content;
    for (int i = 0; i < 5; ++i) content.pictures.push_back({"a", "a", noise});
    scene_.page = &content;
    const auto path = folder_ / "a.html";
    export_scene(scene_, {}, path);
    const std::string page = contents(path);
    const std::size_t mesh_begins = page.find("id=\"glb\">");
    ASSERT_NE(mesh_begins, std::string::npos);
    const std::size_t mesh_bytes = page.find('<', mesh_begins) - mesh_begins;
    EXPECT_LT(page.size() - mesh_bytes, kMostWithoutMesh);
}

TEST_F(Page, AsksForNothing) {
    const auto path = folder_ / "a.html";
    export_scene(scene_, {}, path);
    const std::string page = contents(path);
    EXPECT_CONTAINS(page, "default-src 'none'");
    EXPECT_EQ(page.find("unsafe"), page.npos);
    for (const char* text : {"src=\"http", "href=\"http", "@import", "url(http"})
        EXPECT_EQ(page.find(text), std::string::npos) << text;
}

TEST_F(Page, OtherPagesAreRefused) {
    const auto path = folder_ / "a.html";
    for (const char* text : {"<html></html>", "id=\"glb\">", "id=\"glb\"><", "id=\"glb\">AAAA<", "\0\0"}) {
        put(path, text);
        EXPECT_THROW(describe_mesh(path), Error) << text;
    }
}

TEST(PageWithoutViewer, IsRefusedInOneLine) {
    if (has_viewer()) GTEST_SKIP() << "this build has its viewer";
    const TemporaryFolder folder;
    const SurfaceMesh mesh = sample_mesh(6, 5);
    const auto write = [&] { export_scene({&mesh, nullptr, kGenerator, "{}"}, {}, folder / "a.html"); };
    EXPECT_CONTAINS(test::error_of(write, ErrorKind::output), kNoViewer);
    EXPECT_EQ(folder.entries(), 0);
}

}  // namespace
}  // namespace hexrelief::exporters
