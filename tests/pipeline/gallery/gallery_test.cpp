#include "pipeline/gallery/gallery.h"

#include "exporters/viewer/html_exporter.h"
#include "pipeline/data/error.h"
#include "pipeline/gallery/results.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief {
namespace {

// What matters of a page, and of a report whose run wrote `output`.
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
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "b");
    put(folder / "a.html", page_text("40"));
    put(folder / "a.json", report_text("somewhere/else/a.html"));
    put(folder / "b" / "c.glb", "glb");
    put(folder / "b" / "c.json", report_text((folder / "b" / "c.glb").string()));
    put(folder / "b" / "gone.json", report_text("gone.glb"));
    put(folder / "other.html", "<html>facts</html>");
    put(folder / "broken.html", R"(<script id="facts">{"levels":[</script>)");
    put(folder / "broken.json", "{");
    put(folder / "list.json", "[1]");
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
    if (!has_viewer()) GTEST_SKIP() << kNoViewer;
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "in");
    put(folder / "in" / "a <script>&#\".html", page_text("12345"));
    const auto path = folder / "index.html";
    EXPECT_EQ(write_gallery(folder / "in", path), 1u);
    const std::string page = contents(path);
    EXPECT_NE(page.find("href=\"./in/a%20%3Cscript%3E%26%23%22.html\""), std::string::npos);
    EXPECT_NE(page.find("a &lt;script&gt;&amp;#&quot;</a>"), std::string::npos);
    EXPECT_NE(page.find("<td data-value=\"12345\">12\u202f345</td>"), std::string::npos);
    EXPECT_EQ(page.find("<script>&"), std::string::npos);
    EXPECT_EQ(write_gallery(folder / "in", folder / "in" / "index.html"), 1u);
    EXPECT_EQ(write_gallery(folder / "in", folder / "in" / "index.html"), 1u) << "it lists itself";
}

TEST(Gallery, WhatCannotBeListedIsToldInOneLine) {
    const TemporaryFolder folder;
    for (const auto& from : {folder / "none", folder.path()}) {
        try {
            write_gallery(from, folder / "index.html");
            ADD_FAILURE() << from;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), has_viewer() ? ErrorKind::input : ErrorKind::usage);
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
    }
    EXPECT_EQ(folder.entries(), 0);
}

}  // namespace
}  // namespace hexrelief
