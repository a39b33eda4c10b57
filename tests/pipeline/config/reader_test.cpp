// YAML files and --set: what is accepted, and where the errors point.
#include <gtest/gtest.h>

#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "tests/pipeline/process.h"

namespace hexrelief::config {
namespace {

// The message that reading `text` as my.yaml fails with; empty where it is accepted.
std::string message_of(const std::string& text) {
    Config config;
    return test::refusal_of([&] { apply_yaml(config, text, "my.yaml", "/folder"); }, ErrorKind::usage);
}

void expect_message(const std::string& yaml, const std::vector<std::string>& parts) {
    const std::string message = message_of(yaml);
    for (const std::string& part : parts)
        EXPECT_CONTAINS(message, part) << "'" << message << "' lacks '" << part << "'";
}

TEST(ConfigFile, PartialFilesChangeWhatTheyName) {
    Config config;
    apply_yaml(config, "mesh:\n  spacing_px: 4\n  method: sequential\nexport: {compression: draco}\n", "f",
               "");
    EXPECT_EQ(config.mesh.spacing_px, 4);
    EXPECT_EQ(config.mesh.method, MeshMethod::sequential);
    EXPECT_EQ(config.exporting.compression, exporters::Compression::draco);
    EXPECT_EQ(config.density.exponent, 3);
}

TEST(ConfigFile, EmptyFilesAndSectionsAreFine) {
    for (const char* text : {"", "# only a comment\n", "---\n", "mesh:\n", "mesh: {}\n", "{}", "\n\n",
                             "\xef\xbb\xbfmesh:\n  seed: 1\n"})
        EXPECT_EQ(message_of(text), "") << text;
}

TEST(ConfigFile, UnknownKeysNameTheirLineAndANearKey) {
    expect_message("density:\n  exponent: 3\nmesh:\n  spacing: 4\n",
                   {"my.yaml:4:", "unknown key 'mesh.spacing'", "'mesh.spacing_px'"});
    expect_message("mehs:\n  seed: 4\n", {"my.yaml:1:", "unknown key 'mehs'", "'mesh'"});
    expect_message("spacing_px: 4\n", {"my.yaml:1:", "'mesh.spacing_px'"});
    expect_message("export:\n  draco:\n    <<: 4\n", {"my.yaml:3:", "unknown key"});
}

TEST(ConfigFile, WrongValuesNameLineRangeAndValue) {
    expect_message("mesh:\n  spacing_px: 1\n",
                   {"my.yaml:2:", "mesh.spacing_px must be a number from 2 to 256 px, not '1'"});
    expect_message("mesh:\n  t_max: many\n", {"my.yaml:2:", "an integer from 1", "'many'"});
    expect_message("mesh:\n\n  method: celular\n",
                   {"my.yaml:3:", "one of cellular, sequential", "did you mean 'cellular'"});
    expect_message("disparity:\n  color: maybe\n", {"my.yaml:2:", "true or false", "'maybe'"});
    expect_message("mesh:\n  seed: -1\n", {"my.yaml:2:", "'-1'"});
    expect_message("mesh:\n  seed: null\n", {"my.yaml:2:", "'null'"});
    expect_message("mesh:\n  spacing_px: .nan\n", {"my.yaml:2:"});
    expect_message("mesh:\n  spacing_px: '6'\n", {"my.yaml:2:", "quoted"});
    expect_message("mesh:\n  spacing_px: [6]\n", {"my.yaml:2:", "not a list or section"});
    expect_message("mesh: 6\n", {"my.yaml:1:", "mesh must be a section"});
    expect_message("- mesh\n", {"my.yaml:1:", "top level must be a section"});
    expect_message("just text", {"my.yaml:1:", "top level"});
}

TEST(ConfigFile, DuplicateKeysAreErrors) {
    expect_message("mesh:\n  seed: 1\n  seed: 2\n", {"my.yaml:3:", "duplicate key 'mesh.seed'"});
    expect_message("mesh:\n  seed: 1\ndensity:\nmesh:\n  t_max: 2\n", {"my.yaml:4:", "duplicate key 'mesh'"});
}

TEST(ConfigFile, BrokenYamlNamesItsLine) {
    expect_message("mesh:\n  seed: [1\n", {"my.yaml:", "not valid YAML"});
    expect_message("mesh: {seed: 1\n\ndensity: 4", {"my.yaml:", "not valid YAML"});
    expect_message("mesh:\n\tseed: 1\n", {"my.yaml:2:", "not valid YAML"});
    expect_message("a: *nothing\n", {"my.yaml:1:"});
    expect_message("mesh:\n  seed: 1\n---\nmesh:\n  seed: 2\n", {"more than one YAML document"});
    expect_message("mesh: &m\n  seed: *m\n", {"my.yaml:"});
    EXPECT_NE(message_of(std::string(100000, '[')), "");
}

// The parser of yaml-cpp 0.7 never gets past a comma where a document may begin.
TEST(ConfigFile, CommasEndlessForTheParserAreErrors) {
    expect_message(",", {"my.yaml:1", "not valid YAML"});
    expect_message("mesh: {spacing_px: 4}\n---\n,", {"my.yaml", "more than one YAML document"});
}

TEST(ConfigFile, RulesBetweenFieldsHold) {
    expect_message("disparity:\n  block_size_px: 4\n", {"my.yaml", "block_size_px must be odd"});
    expect_message("mesh:\n  sigma_init: 1\n  sigma_final: 2\n", {"sigma_final"});
    expect_message("input:\n  calibration:\n    focal_px: 100\n    fov_x_deg: 60\n",
                   {"focal_px and fov_x_deg exclude each other"});
}

TEST(ConfigFile, CalibrationIsRelativeToTheFile) {
    Config config;
    apply_yaml(config, "input: {calibration: {file: cams/calib.txt}}", "f", "/some/folder");
    EXPECT_EQ(config.input.calibration.file, "/some/folder/cams/calib.txt");
    apply_yaml(config, "input: {calibration: {file: /cams/calib.txt}}", "f", "/some/folder");
    EXPECT_EQ(config.input.calibration.file, "/cams/calib.txt");
}

TEST(ConfigFile, UnreadableFilesAreUsageErrors) {
    const test::TemporaryFolder folder;
    test::write_text(folder / "binary.yaml", std::string("mesh:\0\0", 7));
    test::write_text(folder / "huge.yaml", std::string(2 << 20, '#'));
    for (const std::string& path :
         {folder / "none.yaml", folder.path().string(), folder / "binary.yaml", folder / "huge.yaml"}) {
        Config config;
        EXPECT_THROW(apply_config_file(config, path), Error) << path;
    }
}

TEST(Setting, ChangesOneKey) {
    Config config;
    apply_setting(config, "mesh.spacing_px=4.5");
    apply_setting(config, "export.compression=draco");
    apply_setting(config, "input.calibration.file=a=b.txt");
    apply_setting(config, "input.disparity.unknown=0");
    apply_setting(config, "input.disparity.unknown=null");
    EXPECT_EQ(config.mesh.spacing_px, 4.5);
    EXPECT_EQ(config.exporting.compression, exporters::Compression::draco);
    EXPECT_EQ(config.input.calibration.file, "a=b.txt");
    EXPECT_TRUE(std::isnan(config.input.disparity.unknown));
}

TEST(Setting, BitsAreGivenOrNull) {
    Config config;
    EXPECT_EQ(config.exporting.draco.position_bits, 0);
    apply_setting(config, "export.draco.position_bits=12");
    EXPECT_EQ(config.exporting.draco.position_bits, 12);
    apply_setting(config, "export.draco.position_bits=null");
    EXPECT_EQ(config.exporting.draco.position_bits, 0);
    EXPECT_THROW(apply_setting(config, "export.draco.position_bits=0"), Error);
    EXPECT_THROW(apply_setting(config, "export.draco.position_bits=x"), Error);
}

TEST(Setting, RefusesWhatItCannotSet) {
    for (const char* setting :
         {"mesh.spacing=4", "mesh.spacing_px", "=4", "", "mesh=4", "mesh.spacing_px=", "mesh.spacing_px=x"}) {
        Config config;
        EXPECT_THROW(apply_setting(config, setting), Error) << setting;
    }
}

}  // namespace
}  // namespace hexrelief::config
