#include "pipeline/cli/arguments/config_options.h"

#include "pipeline/config/presets.h"

namespace hexrelief::cli {

void add_config_options(Command& command, config::ConfigOptions& options, const std::string& group) {
    std::string names;
    for (const config::Preset& preset : config::presets()) names += (names.empty() ? "" : ", ") + preset.name;
    command.add_option("--config", &options.file,
                       "YAML file, see 'hexrelief config show', or a preset: " + names,
                       {.group = group, .value = "F.yaml"});
    command.add_option("--set", &options.settings,
                       "override one key, as in --set mesh.spacing_px=4; may be given several times",
                       {.group = group, .value = "key.path=value", .repeated = true});
}

void add_key_options(Command& command, config::KeyOptions& options, const std::vector<std::string>& flags,
                     const std::string& group) {
    for (const std::string& flag : flags) {
        const config::Field& row = *config::rows_of_option(flag).at(0);
        command.add_option(flag,
                           [&options, flag](const std::string& text) { options.emplace_back(flag, text); },
                           option_help(row), {.group = group, .value = option_value(row)});
    }
}

}  // namespace hexrelief::cli
