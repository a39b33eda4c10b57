// The field table against the structs it describes, and its ranges.
#include "pipeline/config/fields.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "pipeline/config/document.h"
#include "pipeline/config/options.h"
#include "pipeline/config/reader.h"
#include "tests/pipeline/process.h"

namespace hexrelief::config {
namespace {

// Counts an aggregate's members: the most initialisers that it takes.
struct Anything {
    template <typename T>
    operator T() const;
};
template <typename T, typename... A>
constexpr std::size_t member_count(A... a) {
    if constexpr (requires { T{a..., Anything{}}; })
        return member_count<T>(a..., Anything{});
    else
        return sizeof...(A);
}

bool is_number(const Field& field) {
    return field.type != FieldType::boolean && field.type != FieldType::choice &&
           field.type != FieldType::text && field.type != FieldType::file;
}

std::size_t fields_below(const std::string& section) {
    std::size_t count = 0;
    for (const Field& field : config_fields()) count += field.path.starts_with(section + ".");
    return count;
}

TEST(ConfigFields, NameEveryMemberOfEveryStruct) {
    EXPECT_EQ(fields_below("input.disparity") + 3, member_count<readers::DisparityFileConfig>() + 1)
        << "two are what messages advise, one is the caller's; densify is a member of InputConfig";
    EXPECT_EQ(fields_below("input.depth"), member_count<readers::DepthFileConfig>());
    EXPECT_EQ(fields_below("input.mask"), member_count<readers::MaskConfig>());
    EXPECT_EQ(fields_below("input.confidence"), member_count<readers::ConfidenceConfig>());
    EXPECT_EQ(fields_below("input.calibration"), member_count<CalibrationConfig>());
    EXPECT_EQ(fields_below("input.stereo"), member_count<readers::StereoFileConfig>());
    EXPECT_EQ(fields_below("disparity"), member_count<stages::DisparityConfig>());
    EXPECT_EQ(fields_below("density"), member_count<stages::DensityConfig>());
    EXPECT_EQ(fields_below("mesh"), member_count<MeshConfig>() + member_count<BalanceConfig>() - 1);
    EXPECT_EQ(fields_below("mesh.balance"), member_count<BalanceConfig>());
    EXPECT_EQ(fields_below("surface"), member_count<SurfaceConfig>());
    EXPECT_EQ(fields_below("export"),
              member_count<exporters::DracoConfig>() + member_count<exporters::ExportConfig>() - 1);
    EXPECT_EQ(fields_below("run"), member_count<ExecutionConfig>());
}

TEST(ConfigFields, PathsAreUniqueAndHaveASectionAndHelp) {
    std::set<std::string> paths;
    for (const Field& field : config_fields()) {
        EXPECT_TRUE(paths.insert(field.path).second) << field.path;
        EXPECT_TRUE(find_section(field.path.substr(0, field.path.rfind('.')))) << field.path;
        EXPECT_FALSE(field.help.empty()) << field.path;
        EXPECT_EQ(field.help.find('\n'), std::string::npos) << field.path;
    }
}

TEST(ConfigFields, DefaultsAreInRangeAndReadBack) {
    for (const Field& field : config_fields()) {
        Config config;
        const std::string text = format_value(field.get(config));
        EXPECT_EQ(assign_text(config, field, text), "") << field.path;
        EXPECT_EQ(format_value(field.get(config)), text) << field.path;
    }
    EXPECT_NO_THROW(check_rules(Config{}, ""));
}

// Sets each field alone and looks whether it and no other changes: a row with another row's member would be
// caught.
TEST(ConfigFields, EachSetsItsOwnMemberAlone) {
    for (const Field& field : config_fields()) {
        Config changed;
        const Config untouched;
        std::string value;
        switch (field.type) {
            case FieldType::boolean:
                value = std::get<bool>(field.get(changed)) ? "false" : "true";
                break;
            case FieldType::choice:
                value = field.choices.back() == std::get<std::string>(field.get(changed))
                            ? field.choices.front()
                            : field.choices.back();
                break;
            case FieldType::text:
            case FieldType::file:
                value = "some/file.txt";
                break;
            default: {
                const std::string least = format_value(FieldValue(field.range.min));
                value = least == format_value(field.get(changed)) ? format_value(FieldValue(field.range.max))
                                                                  : least;
                if (field.type == FieldType::integer && value.find('e') != std::string::npos) value = "1000";
            }
        }
        ASSERT_EQ(assign_text(changed, field, value), "") << field.path;
        for (const Field& other : config_fields()) {
            const bool same = format_value(other.get(changed)) == format_value(other.get(untouched));
            EXPECT_EQ(same, other.path != field.path) << field.path << " and " << other.path;
        }
    }
}

TEST(ConfigFields, RefuseWhatLiesOutsideTheRange) {
    for (const Field& field : config_fields()) {
        if (!is_number(field)) continue;
        Config config;
        const std::string below = format_value(FieldValue(field.range.min - 1)),
                          above = format_value(FieldValue(2 * field.range.max + 10));
        EXPECT_NE(assign_text(config, field, below), "") << field.path;
        EXPECT_NE(assign_text(config, field, above), "") << field.path;
        for (const char* text :
             {"abc", "nan", "inf", "-inf", ".inf", "1x", "1 2", "0x10", "true", "--1", "+-1"})
            EXPECT_NE(assign_text(config, field, text), "") << field.path << " " << text;
    }
}

TEST(ConfigFields, IntegersTakeNoFractions) {
    Config config;
    EXPECT_NE(assign_text(config, *find_field("mesh.t_max"), "12.5"), "");
    EXPECT_NE(assign_text(config, *find_field("mesh.t_max"), "99999999999999999999999"), "");
    EXPECT_EQ(assign_text(config, *find_field("mesh.t_max"), "12"), "");
    EXPECT_EQ(config.mesh.t_max, 12);
}

TEST(Suggest, FindsSlipsAndMissingUnits) {
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
    EXPECT_EQ(edit_distance("", "abc"), 3);
    EXPECT_EQ(edit_distance("ab", "ba"), 1);
    EXPECT_CONTAINS(suggest_key("mesh.spacing"), "'mesh.spacing_px'");
    EXPECT_CONTAINS(suggest_key("spacing_px"), "'mesh.spacing_px'");
    EXPECT_CONTAINS(suggest_key("mseh"), "'mesh'");
    EXPECT_CONTAINS(suggest_key("export.draco.leve"), "'export.draco.level'");
    EXPECT_EQ(suggest_key("quite_another_thing_altogether"), "");
}

TEST(ConfigDocument, YamlRoundTrips) {
    Config config;
    for (const Field& field : config_fields()) {
        if (field.type == FieldType::boolean) field.set(config, true);
        if (field.type == FieldType::integer && field.is_optional)
            field.set(config, static_cast<long long>(field.range.max));
        if (field.type != FieldType::real) continue;
        field.set(config, field.is_optional ? std::max(field.range.min, 0.1)
                                            : field.range.min + (field.range.max - field.range.min) / 3);
    }
    config.input.calibration.file = "/a folder/with: \"odd\" #name \\ \xc3\xa9.txt";
    config.input.calibration.fov_x_deg = kNotGiven;
    config.input.depth.near_m = 1;
    config.input.depth.unit = "mm";
    config.disparity.block_size_px = 7;
    config.mesh.alpha_final = 0.1;
    config.mesh.alpha_init = 0.3;
    config.mesh.seed = 9007199254740991;
    Config again;
    apply_yaml(again, config_yaml(config), "text", "/elsewhere");
    for (const Field& field : config_fields())
        EXPECT_EQ(format_value(field.get(again)), format_value(field.get(config))) << field.path;
    EXPECT_EQ(config_yaml(again), config_yaml(config));
}

TEST(ConfigDocument, DefaultFileIsWhatShowPrints) {
    EXPECT_EQ(test::read_text(std::string(HEXRELIEF_SOURCE_DIR) + "/config/default.yaml"),
              config_yaml(Config{}))
        << "run: hexrelief config show > config/default.yaml";
}

TEST(ConfigDocument, SchemaKnowsEveryKeyAndNoOther) {
    const auto schema = nlohmann::json::parse(config_schema());
    EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    std::size_t leaves = 0;
    const std::function<void(const nlohmann::json&, const std::string&)> walk =
        [&](const nlohmann::json& node, const std::string& path) {
            if (!node.contains("properties")) {
                ++leaves;
                EXPECT_TRUE(find_field(path)) << path;
                EXPECT_TRUE(node.contains("default")) << path;
                return;
            }
            EXPECT_EQ(node["additionalProperties"], false) << path;
            for (const auto& [name, child] : node["properties"].items())
                walk(child, path.empty() ? name : path + "." + name);
        };
    walk(schema, "");
    EXPECT_EQ(leaves, config_fields().size());
    EXPECT_EQ(schema["properties"]["mesh"]["properties"]["spacing_px"]["minimum"], 2);
    EXPECT_EQ(schema["properties"]["mesh"]["properties"]["method"]["enum"].size(), 2u);
}

TEST(ConfigDocument, MarkdownNamesEveryKey) {
    const std::string page = config_markdown();
    for (const Field& field : config_fields())
        EXPECT_CONTAINS(page, "\n- `" + field.path + "` (default `") << field.path;
    for (const Section& section : config_sections())
        EXPECT_CONTAINS(page, "# `" + section.path + "`\n\n" + section.help + ".\n") << section.path;
    std::istringstream lines(page);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 132u) << line;
}

// `--config NAME` is the file of that name in config/.
TEST(ConfigDocument, PresetsAreBuiltIn) {
    std::set<std::string> names;
    for (const Preset& preset : presets()) {
        names.insert(preset.name);
        std::string file = HEXRELIEF_SOURCE_DIR "/config/";
        file.append(preset.name).append(".yaml");
        EXPECT_EQ(preset.yaml, test::read_text(file)) << preset.name;
        EXPECT_EQ(config_yaml(read_config({preset.name}, {})), config_yaml(read_config({file}, {})))
            << preset.name;
    }
    for (const char* name : {"default", "quality", "compact", "paper", "som"})
        EXPECT_TRUE(names.contains(name)) << name;
    EXPECT_EQ(find_preset("aloe"), nullptr) << "one scene's camera, not a preset";
    EXPECT_EQ(find_preset(""), nullptr);
    EXPECT_EQ(read_config({"quality"}, {"mesh.spacing_px=5"}).mesh.spacing_px, 5);
}

TEST(ConfigDocument, PresetsAreValid) {
    for (const char* name : {"default", "quality", "compact", "paper", "som", "aloe"}) {
        Config config;
        EXPECT_NO_THROW(
            apply_config_file(config, std::string(HEXRELIEF_SOURCE_DIR) + "/config/" + name + ".yaml"))
            << name;
    }
    Config aloe;
    apply_config_file(aloe, std::string(HEXRELIEF_SOURCE_DIR) + "/config/aloe.yaml");
    EXPECT_EQ(aloe.input.calibration.focal_px, 3740);
    EXPECT_EQ(aloe.input.calibration.baseline_m, 0.160);
    EXPECT_EQ(aloe.input.calibration.doffs_px, 270);
    Config paper;
    apply_config_file(paper, std::string(HEXRELIEF_SOURCE_DIR) + "/config/paper.yaml");
    EXPECT_EQ(paper.mesh.levels, 1);
    EXPECT_EQ(paper.mesh.t_max, 1500);
    EXPECT_EQ(paper.mesh.magnification, 1);
    EXPECT_FALSE(paper.mesh.balance.enabled);
}

}  // namespace
}  // namespace hexrelief::config
