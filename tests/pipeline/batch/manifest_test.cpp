// Tests the command lines that manifests and folders become.
#include "pipeline/batch/manifest.h"

#include <gtest/gtest.h>

#include "pipeline/batch/manifest_rows.h"
#include "pipeline/config/options.h"
#include "tests/pipeline/process.h"

namespace hexrelief::batch {
namespace {

using namespace test;

using test::TemporaryFolder;
using test::write_text;

using Words = std::vector<std::string>;

const ManifestOptions kOptions{
    .output = "out", .file_options = {"--left", "--right", "--stereo", "--disparity", "--depth", "--mask"}};

std::vector<BatchUnit> read_units(const TemporaryFolder& folder, const std::string& name,
                                  const std::string& text) {
    write_text(folder / name, text);
    return read_manifest(folder / name, kOptions);
}

// Returns the error in the only row of a manifest.
std::string wrong_of(const std::string& name, const std::string& text) {
    const TemporaryFolder folder;
    const std::vector<BatchUnit> units = read_units(folder, name, text);
    return units.size() == 1 ? units[0].wrong : "not one row";
}

TEST(Manifest, AllFormatsGiveTheSameCommands) {
    const TemporaryFolder folder;
    const Words wanted = {"--left",      folder / "l.png",
                          "--right",     folder / "sub/r.png",
                          "--set",       "mesh.spacing_px=4",
                          "--seed=-7",   "-o",
                          "out/a b.glb", "-o",
                          "out/a b.drc", "--report",
                          "out/a b.json"};
    const std::vector<std::pair<std::string, std::string>> manifests = {
        {"m.csv",
         "left,right,mesh.spacing_px,seed,name,formats,mask\nl.png,./sub/r.png,4,-7,\"a b\",\"glb,drc\",\n"},
        {"m.jsonl", R"({"left":"l.png","right":"sub/r.png","mesh":{"spacing_px":4},"seed":-7,)"
                    R"("name":"a b","formats":["glb","drc"],"mask":null})"},
        {"m.yaml",
         "- left: l.png\n  right: sub/r.png\n  mesh:\n    spacing_px: 4\n  seed: -7\n  name: a b\n"
         "  formats: [glb, drc]\n  mask:\n"},
    };
    for (const auto& [name, text] : manifests) {
        const std::vector<BatchUnit> units = read_units(folder, name, text);
        ASSERT_EQ(units.size(), 1u) << name;
        EXPECT_EQ(units[0].wrong, "") << name;
        EXPECT_EQ(units[0].words, wanted) << name;
        EXPECT_EQ(units[0].name, "a b");
    }
}

TEST(Manifest, YamlDefaultsGiveWayToTheRow) {
    const TemporaryFolder folder;
    const auto units = read_units(folder, "m.yml",
                                  "defaults:\n  calib: c.txt\n  mesh.spacing_px: 9\n"
                                  "rows:\n- {disparity: a.pfm}\n- {disparity: b.pfm, mesh.spacing_px: 5}\n");
    ASSERT_EQ(units.size(), 2u);
    EXPECT_EQ(units[0].words[3], "mesh.spacing_px=9");
    EXPECT_EQ(units[1].words[3], "mesh.spacing_px=5");
    EXPECT_EQ(units[1].words[1], folder / "c.txt");
    EXPECT_EQ(units[1].place, (folder / "m.yml") + ":6");
}

TEST(Manifest, YamlDefaultsGiveWayToTheRowHoweverItSpellsTheKey) {
    const TemporaryFolder folder;
    const auto units = read_units(folder, "m.yml",
                                  "defaults: {calibration: c.txt, max-bytes: 9, output: x, seed: 1}\n"
                                  "rows:\n- {disparity: a.pfm, calib: d.txt, max_bytes: 5, name: y}\n"
                                  "- {disparity: a.pfm, calib: d.txt, calibration: e.txt}\n"
                                  "- {disparity: a.pfm, name: z, seed: 2, seed: 3}\n");
    ASSERT_EQ(units.size(), 3u);
    EXPECT_EQ(units[0].wrong, "");
    EXPECT_EQ(units[0].name, "y");
    EXPECT_EQ(units[0].words, (Words{"--calib", folder / "d.txt", "--max-bytes=5", "--seed=1", "--disparity",
                                     folder / "a.pfm", "-o", "out/y.glb", "--report", "out/y.json"}));
    EXPECT_CONTAINS(units[1].wrong, "'calib' is given twice");
    EXPECT_CONTAINS(units[2].wrong, "'seed' is given twice");
}

TEST(Manifest, NamesComeFromTheFirstInput) {
    const TemporaryFolder folder;
    const auto units =
        read_units(folder, "m.csv", "left,disparity\nx/cones_left.png,\ny/teddy/left.png,\n,z/aloe.pfm\n");
    ASSERT_EQ(units.size(), 3u);
    EXPECT_EQ(units[0].name, "cones");
    EXPECT_EQ(units[1].name, "teddy");
    EXPECT_EQ(units[2].name, "aloe");
}

TEST(Manifest, RowsSayWhatIsWrongWithThem) {
    EXPECT_CONTAINS(wrong_of("m.csv", "lefft\na.png\n"), "did you mean 'left'");
    EXPECT_CONTAINS(wrong_of("m.csv", "left,right\na,b,c\n"), "3 cells, but the header names 2");
    EXPECT_CONTAINS(wrong_of("m.csv", "left\n\"a\n"), "never closed");
    EXPECT_CONTAINS(wrong_of("m.csv", "left,calib,calibration\na,b,c\n"), "'calib' is given twice");
    EXPECT_EQ(wrong_of("m.csv", "left,strict\na,yes\n"), "strict must be true or false, not 'yes'");
    EXPECT_CONTAINS(wrong_of("m.csv", "left,fov\na,60\n"), "did you mean 'fov-x'");
    EXPECT_CONTAINS(wrong_of("m.jsonl", "{\"left\": }\n"), "not valid JSON");
    EXPECT_CONTAINS(wrong_of("m.jsonl", "[1]\n"), "not a JSON object");
    EXPECT_CONTAINS(wrong_of("m.yaml", "- left: {a: {b: {c: {d: {e: 1}}}}}\n"), "too deep");
    // The error in a row is a single line.
    for (const std::string row : {"left,strict\na,\"x\ny\"\n", "left,\"x.\ny\",\"x.\ny\"\na,1,2\n"}) {
        const std::string wrong = wrong_of("m.csv", row);
        EXPECT_FALSE(wrong.empty() || wrong.find('\n') != std::string::npos) << wrong;
    }
    for (const std::string name : {"../a", "/a", "a/", "batch", "."})
        EXPECT_NE(wrong_of("m.csv", "left,name\nl.png," + name + "\n"), "") << name;
    EXPECT_CONTAINS(wrong_of("m.csv", "name,mesh.spacing_px\n,4\n"), "give the row a 'name'");
}

TEST(Manifest, TheSecondOfTwoRowsOfOneNameIsWrong) {
    const TemporaryFolder folder;
    const auto units = read_units(folder, "m.csv", "left\na/x.png\nb/x.png\n");
    ASSERT_EQ(units.size(), 2u);
    EXPECT_EQ(units[0].wrong, "");
    EXPECT_CONTAINS(units[1].wrong, "m.csv:2");
}

TEST(Manifest, FilesThatAreNoneAreRefused) {
    const TemporaryFolder folder;
    for (const auto& [name, text] :
         std::vector<std::pair<std::string, std::string>>{{"a.csv", ""},
                                                          {"b.csv", "left,right\n"},
                                                          {"c.jsonl", "\n\n"},
                                                          {"d.yaml", "left: a\n"},
                                                          {"e.yaml", "- {\n"},
                                                          {"f.yaml", "- left: a\n---\n- left: b\n"},
                                                          {"g.yaml", ",\n"},
                                                          {"h.yaml", "rows: []\n"},
                                                          {"i.yaml", "defaults: [1]\nrows: [{left: a}]\n"},
                                                          {"j.txt", "# nothing\n"}})
        EXPECT_THROW(read_units(folder, name, text), Error) << name;
    EXPECT_THROW(read_manifest(folder / "none.csv", kOptions), Error);
    write_text(folder / "k.csv", "left\na\n");
    EXPECT_THROW(read_manifest(folder / "k.csv", {}), Error) << "no output folder";
}

TEST(Manifest, CsvMayHaveQuotesLineEndsAndAByteOrderMark) {
    const auto rows = csv_rows("\xef\xbb\xbfleft,name\r\n\"a \"\"b\"\"\n.png\",x\r\n\r\nc.png,\"\"\r\n", "m");
    ASSERT_EQ(rows.size(), 2u);
    ASSERT_EQ(rows[0].values.size(), 2u);
    EXPECT_EQ(rows[0].values[0].first, "left");
    EXPECT_EQ(rows[0].values[0].second, "a \"b\"\n.png");
    EXPECT_EQ(rows[1].place, "m:5");
    EXPECT_EQ(rows[1].values.size(), 1u);
}

TEST(ShellWords, AreReadAndWritten) {
    EXPECT_EQ(config::words_of_line(R"(-o "a b" c)"), (Words{"-o", "a b", "c"}));
    EXPECT_EQ(config::shell_line({"a", "b c", "it's", ""}), R"(a 'b c' 'it'\''s' '')");
    EXPECT_THROW(config::shell_quoted("a\nb"), Error);
}

TEST(Manifest, OneFileUnderTwoNamesIsFound) {
    const TemporaryFolder folder;
    std::filesystem::create_directory_symlink(".", folder / "l");
    write_text(folder / "m.csv", "left,right,name\na,b,x\na,b,l/x\n");
    ManifestOptions options = kOptions;
    options.output = folder.path();
    const std::vector<BatchUnit> units = read_manifest(folder / "m.csv", options);
    ASSERT_EQ(units.size(), 2u);
    EXPECT_EQ(units[0].wrong, "");
    EXPECT_CONTAINS(units[1].wrong, "is that of");
}

TEST(Manifest, WhatWouldFillTheMemoryIsRefusedByItsSize) {
    const TemporaryFolder folder;
    EXPECT_THROW(read_units(folder, "m.csv", "left,right\n" + std::string(2 << 20, ',')), Error);
    EXPECT_THROW(read_units(folder, "m.yaml", std::string(3 << 20, '[')), Error);
    EXPECT_CONTAINS(wrong_of("m.jsonl", R"({"left":)" + std::string(100000, '[')), "nested");
}

TEST(ShellWords, HaveNoControlCharacters) {
    EXPECT_EQ(config::shell_quoted("\x1b[31m\xc2\x9b'\\\xc3\xa4"), R"($'\x1b[31m\xc2\x9b\'\\\xc3\xa4')");
    EXPECT_EQ(config::shell_quoted("\xc3\xa4"), "'\xc3\xa4'");
}

}  // namespace
}  // namespace hexrelief::batch
