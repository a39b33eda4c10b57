// A row of the field table that names an option is all that the commands need.
#include "pipeline/config/options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "pipeline/batch/manifest.h"
#include "pipeline/config/document.h"
#include "pipeline/data/error.h"
#include "tests/pipeline/process.h"

namespace hexrelief::config {
namespace {

using test::run_program;
using test::TemporaryFolder;

std::vector<Field> rows_with_options() {
    std::vector<Field> rows;
    for (const Field& field : config_fields())
        if (!field.option.flag.empty()) rows.push_back(field);
    return rows;
}

// A value other than the default one.
std::string some_value(const Field& field) {
    if (field.type == FieldType::boolean) return "true";
    if (!field.choices.empty()) return field.choices.back();
    if (field.type == FieldType::text || field.type == FieldType::file) return "7";
    return format_value(FieldValue(field.range.min + 1));
}

std::string error_of(const std::string& flag, const std::vector<std::string>& files) {
    return test::error_of([&] { row_of_option(flag, files); }, ErrorKind::usage);
}

TEST(KeyOptions, StandInHelpManualCompletionsAndDocuments) {
    const std::string help = run_program({"run", "--help"}).out, manual = run_program({"manual", "run"}).out,
                      keys = config_yaml({});
    std::map<std::string, std::string> scripts;
    for (const char* const shell : {"bash", "zsh", "fish"})
        scripts[shell] = run_program({"completion", shell}).out;
    for (const Field& row : rows_with_options()) {
        const std::string &flag = row.option.flag, value = option_value(row);
        const std::string shown = flag + " " + value;
        const std::size_t at = help.find("\n  " + shown);
        ASSERT_NE(at, std::string::npos) << flag;
        const std::size_t end = help.find("\n  --", at + 1);
        EXPECT_CONTAINS(help.substr(at, end - at), option_help(row)) << flag;
        EXPECT_CONTAINS(keys, "; also " + flag + "  [") << flag;
        std::string dashed;
        for (const char c : flag) dashed += c == '-' ? "\\-" : std::string(1, c);
        EXPECT_CONTAINS(manual, "\\fB" + dashed + "\\fR") << flag;
        for (const auto& [shell, script] : scripts) {
            const std::string name = shell == "fish" ? "-l " + flag.substr(2) : flag;
            EXPECT_CONTAINS(script, name) << shell << " " << flag;
            std::string words;
            for (const std::string& choice : row.choices) words += (words.empty() ? "" : " ") + choice;
            EXPECT_CONTAINS(script, words) << shell << " " << flag;
        }
    }
}

TEST(KeyOptions, AreKeysOfManifests) {
    const TemporaryFolder folder;
    for (const Field& row : rows_with_options()) {
        const std::string &flag = row.option.flag, value = some_value(row);
        test::write_text(folder / "m.csv", "name," + flag.substr(2) + "\na," + value + "\n");
        const std::vector<batch::BatchUnit> units = batch::read_manifest(folder / "m.csv", {.output = "out"});
        ASSERT_EQ(units.size(), 1u);
        EXPECT_EQ(units[0].wrong, "") << flag;
        const bool is_flag = row.type == FieldType::boolean, is_file = row.type == FieldType::file;
        EXPECT_EQ(units[0].words[0], is_flag || is_file ? flag : flag + "=" + value);
        if (is_file) {
            EXPECT_EQ(units[0].words[1], folder / value);
        }
    }
}

TEST(KeyOptions, ASecondCalibrationIsTheOtherFile) {
    Config config;
    apply_options(config, {{"--calib", "left.yaml"}, {"--fov-x", "60"}, {"--calib", "right.yaml"}}, {});
    EXPECT_EQ(config.input.calibration.file, "left.yaml");
    EXPECT_EQ(config.input.calibration.second_file, "right.yaml");
    const std::pair<std::string, std::string> one{"--calib", "a"};
    EXPECT_THROW(apply_options(config, {one, one, one}, {}), Error);
}

TEST(KeyOptions, SetTheirRowsAsTheyAreTyped) {
    for (const Field& row : rows_with_options()) {
        Config config;
        const std::string value = some_value(row), file = find_section(section_of(row.path))->file;
        apply_options(config, {{row.option.flag, value}}, {file});
        EXPECT_EQ(format_value(row.get(config)), value) << row.path;
        EXPECT_TRUE(config.given.contains(row.path));
    }
    Config config;
    apply_options(config, {{"--fov-x", "61.30000000000000001"}}, {});
    EXPECT_EQ(config.input.calibration.fov_x_deg, 61.3);
    EXPECT_THROW(apply_options(config, {{"--fov-x", "0"}}, {}), Error);
}

TEST(KeyOptions, OfOneFlagGoWithFilesOfTheirOwn) {
    std::map<std::string, std::vector<const Field*>> rows;
    for (const Field& row : rows_with_options()) rows[row.option.flag] = rows_of_option(row.option.flag);
    for (const auto& [flag, same] : rows) {
        std::vector<std::string> files;
        for (const Field* row : same) {
            EXPECT_EQ(row->type, same[0]->type) << flag;
            EXPECT_EQ(option_help(*row), option_help(*same[0])) << flag;
            files.push_back(find_section(section_of(row->path))->file);
            if (same.size() > 1) {
                EXPECT_FALSE(files.back().empty()) << flag;
                EXPECT_EQ(row_of_option(flag, {files.back()}).path, row->path);
            }
        }
        std::sort(files.begin(), files.end());
        EXPECT_EQ(std::unique(files.begin(), files.end()), files.end()) << flag;
    }
    EXPECT_EQ(error_of("--unknown", {"--left"}),
              "--unknown goes with --disparity or --depth, which is not given");
    EXPECT_EQ(error_of("--layout", {"--depth"}), "--layout goes with --stereo, which is not given");
    EXPECT_EQ(error_of("--output", {}), "'--output' stands for no key");
    EXPECT_EQ(error_of("", {}), "'' stands for no key");
}

}  // namespace
}  // namespace hexrelief::config
