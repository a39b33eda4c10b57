#include "pipeline/cli/gallery/gallery.h"

#include "exporters/images/image_writer.h"
#include "exporters/viewer/html_exporter.h"
#include "pipeline/data/error.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::cli {
namespace {

// The relevant parts of a page, and of a report whose run wrote `output`.
std::string page_text(const std::string& triangles) {
    return R"(<script id="facts">{"levels":[{"vertices":30,"triangles":)" + triangles +
           R"(}],"figures":[{"name":"%cost","value":1.5},5],)"
           R"("pictures":[{"name":"relief","source":"data:x"}]}</script>)";
}
std::string report_text(const std::string& output) {
    return R"({"hexrelief":{},"mesh":{"percent_cost":2},"surface":{"vertices":7,"triangles":8},"seconds":3,)"
           R"("outputs":[5,{"path":")" +
           output + R"("}]})";
}

TEST(Gallery, PagesAndReportsOfOneRunAreOneResult) {
    const exporters::TemporaryFolder folder;
    std::filesystem::create_directory(folder / "b");
    exporters::put(folder / "a.html", page_text("40"));
    exporters::put(folder / "a.json", report_text("somewhere/else/a.html"));
    exporters::put(folder / "b" / "c.glb", "glb");
    exporters::put(folder / "b" / "c.json", report_text((folder / "b" / "c.glb").string()));
    exporters::put(folder / "b" / "gone.json", report_text("gone.glb"));
    exporters::put(folder / "other.html", "<html>facts</html>");
    exporters::put(folder / "broken.html", R"(<script id="facts">{"levels":[</script>)");
    exporters::put(folder / "broken.json", "{");
    exporters::put(folder / "list.json", "[1]");
    const std::vector<FoundResult> results = find_results(folder.path());
    ASSERT_EQ(results.size(), 2u);
    EXPECT_EQ(results[0].file, folder / "a.html");
    EXPECT_EQ(results[0].picture, "data:x");
    EXPECT_EQ(results[0].figures.triangles, 40);
    EXPECT_EQ(results[0].figures.percent_cost, 1.5);
    EXPECT_TRUE(std::isnan(results[0].figures.error_px));
    EXPECT_EQ(results[0].figures.seconds, 3);
    EXPECT_EQ(results[1].file, folder / "b" / "c.glb");
    EXPECT_EQ(results[1].figures.bytes, 3);
    EXPECT_EQ(results[1].figures.vertices, 7);
}

TEST(Gallery, ListsLinksThatAreSafe) {
    if (!exporters::has_viewer()) GTEST_SKIP() << exporters::kNoViewer;
    const exporters::TemporaryFolder folder;
    std::filesystem::create_directory(folder / "in");
    exporters::put(folder / "in" / "a <script>&#\".html", page_text("12345"));
    const auto path = folder / "index.html";
    EXPECT_EQ(write_gallery(folder / "in", path), 1u);
    const std::string page = exporters::contents(path);
    EXPECT_CONTAINS(page, "href=\"./in/a%20%3Cscript%3E%26%23%22.html\"");
    EXPECT_CONTAINS(page, "a &lt;script&gt;&amp;#&quot;</a>");
    EXPECT_CONTAINS(page, "<td data-name=\"Triangles\" data-value=\"12345\">12\u202f345</td>");
    EXPECT_EQ(page.find("<script>&"), std::string::npos);
    EXPECT_EQ(write_gallery(folder / "in", folder / "in" / "index.html"), 1u);
    EXPECT_EQ(write_gallery(folder / "in", folder / "in" / "index.html"), 1u) << "it lists itself";
}

TEST(Gallery, NeverReplacesWhatItLists) {
    if (!exporters::has_viewer()) GTEST_SKIP() << exporters::kNoViewer;
    const exporters::TemporaryFolder folder;
    exporters::put(folder / "index.html", page_text("40"));
    std::filesystem::create_symlink(folder / "index.html", folder / "link.html");
    for (const auto& path :
         {folder / "index.html", folder / "link.html", folder / "a.glb", std::filesystem::path("-")})
        test::error_of([&] { write_gallery(folder.path(), path); }, ErrorKind::usage);
    EXPECT_EQ(exporters::contents(folder / "index.html"), page_text("40"));
}

TEST(Gallery, JsonOfOthersIsPassedOver) {
    const exporters::TemporaryFolder folder;
    exporters::put(folder / "a.HTML", page_text("40"));
    exporters::put(folder / "b.html",
                   R"(<script id="facts">{"levels":[{}],"figures":5,"pictures":[{"name":7}]})");
    exporters::put(folder / "c.json", R"({"hexrelief":{},"mesh":3,"surface":[],"outputs":[{"path":7}]})");
    const std::vector<FoundResult> results = find_results(folder.path());
    ASSERT_EQ(results.size(), 1u);
    EXPECT_EQ(results[0].file, folder / "a.HTML");
}

// As after `cd folder; hexrelief run -o meshes/a.glb --report reports/a.json`.
TEST(Gallery, MeshesMayLieInAnotherFolder) {
    const exporters::TemporaryFolder folder;
    std::filesystem::create_directory(folder / "meshes");
    std::filesystem::create_directory(folder / "reports");
    exporters::put(folder / "meshes" / "a.glb", "glb");
    exporters::put(folder / "reports" / "a.json", report_text("meshes/a.glb"));
    const std::vector<FoundResult> results = find_results(folder.path());
    ASSERT_EQ(results.size(), 1u);
    EXPECT_EQ(std::filesystem::canonical(results[0].file),
              std::filesystem::canonical(folder / "meshes" / "a.glb"));
}

TEST(Gallery, AStagePictureBelongsToTheOnlyReport) {
    const exporters::TemporaryFolder folder;
    exporters::write_png(folder / "relief.png", {4, 4, 1, std::vector<std::uint8_t>(16, 90)});
    exporters::put(folder / "a.glb", "glb");
    exporters::put(folder / "a.json", report_text("a.glb"));
    ASSERT_EQ(find_results(folder.path()).size(), 1u);
    EXPECT_NE(find_results(folder.path())[0].picture, "");
    exporters::put(folder / "b.glb", "glb");
    exporters::put(folder / "b.json", report_text("b.glb"));
    for (const FoundResult& result : find_results(folder.path())) EXPECT_EQ(result.picture, "");
}

TEST(Gallery, WhatCannotBeListedIsToldInOneLine) {
    const exporters::TemporaryFolder folder;
    for (const auto& from : {folder / "none", folder.path()})
        test::error_of([&] { write_gallery(from, folder / "index.html"); },
                       exporters::has_viewer() ? ErrorKind::input : ErrorKind::usage);
    EXPECT_EQ(folder.entries(), 0);
}

// Parsing or copying what is nested 100,000 times would exhaust the stack; a sparse file would fill the
// memory.
TEST(Gallery, ForeignFilesNeitherEndItNorHoldItUp) {
    const exporters::TemporaryFolder folder;
    const std::string nested = std::string(100000, '[') + std::string(100000, ']');
    exporters::put(folder / "a.html",
                   R"(<script id="facts">{"levels":[{"vertices":1}],"figures":)" + nested + "}<");
    exporters::put(folder / "a.json", R"({"hexrelief":1,"surface":{},"mesh":{},"outputs":)" + nested + "}");
    exporters::put(folder / "sparse.html", "");
    std::filesystem::resize_file(folder / "sparse.html", std::uintmax_t{20} << 30);
    exporters::put(folder / "sparse.json", "");
    std::filesystem::resize_file(folder / "sparse.json", std::uintmax_t{20} << 30);
    std::filesystem::create_symlink("/dev/zero", folder / "device.html");
    std::filesystem::create_symlink("/proc/kmsg", folder / "log.json");
    exporters::put(folder / "page.html", std::string(200000, 'x') + page_text("40"));
    const std::vector<FoundResult> results = find_results(folder.path());
    ASSERT_EQ(results.size(), 1u);
    EXPECT_EQ(results[0].file, folder / "page.html");
    EXPECT_EQ(results[0].figures.triangles, 40);
}

}  // namespace
}  // namespace hexrelief::cli
