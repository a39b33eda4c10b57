#include "pipeline/config/options.h"

#include <CLI/CLI.hpp>

#include "pipeline/config/fields.h"
#include "pipeline/config/reader.h"
#include "pipeline/config/presets.h"

namespace hexrelief {

void add_config_options(CLI::App& command, ConfigOptions& options, const std::string& group) {
    std::string names;
    for (const Preset& preset : presets()) names += (names.empty() ? "" : ", ") + preset.name;
    command
        .add_option("--config", options.file, "YAML file, see 'hexrelief config show', or a preset: " + names)
        ->type_name("F.yaml")
        ->group(group);
    command
        .add_option("--set", options.settings,
                    "override one key, as in --set mesh.spacing_px=4; may be given several times")
        ->type_name("key.path=value")
        ->expected(1)
        ->take_all()
        ->group(group);
}

Config read_config(const ConfigOptions& options) {
    Config config;
    if (const Preset* preset = find_preset(options.file))
        apply_yaml(config, preset->yaml, "preset " + preset->name, {});
    else if (!options.file.empty())
        apply_config_file(config, options.file);
    for (const std::string& setting : options.settings) apply_setting(config, setting);
    return config;
}

void apply_option(Config& config, const std::string& option, const std::string& path,
                  const std::string& value) {
    const Field* field = find_field(path);
    if (!field) throw std::logic_error("no field " + path);
    if (const std::string wrong = assign_text(config, *field, value); !wrong.empty())
        throw Error(ErrorKind::usage, option + " " + wrong);
}

void finish_config(const Config& config) {
    check_rules(config, "");
}

std::string shortest(double value) {
    return format_value(FieldValue(value));
}

}  // namespace hexrelief
