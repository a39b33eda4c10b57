#include "pipeline/cli/arguments/config_options.h"

#include "pipeline/config/presets.h"
#include "pipeline/data/error.h"

namespace hexrelief::cli {

namespace {

void add_setting(Options& options, const std::string& setting) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos)
        throw Error(ErrorKind::usage, "--set " + setting + ": write it as key.path=value");
    options.settings.emplace_back(setting.substr(0, equals), setting.substr(equals + 1));
}

}  // namespace

void add_config_options(Command& command, Options& options, const std::string& group) {
    std::string names;
    for (const config::Preset& preset : config::presets()) names += (names.empty() ? "" : ", ") + preset.name;
    command.add_option("--config", &options.config,
                       "YAML file, see 'hexrelief config show', or a preset: " + names +
                           "; may be given several times, later ones win",
                       {.group = group, .value = "F.yaml", .repeated = true});
    command.add_option("--set", [&options](const std::string& setting) { add_setting(options, setting); },
                       "override one key, as in --set mesh.spacing_px=4; may be given several times",
                       {.group = group, .value = "key.path=value", .repeated = true});
}

void add_key_options(Command& command, Options& options, const std::vector<std::string>& flags,
                     const std::string& group) {
    for (const std::string& flag : flags) {
        const config::Field& row = *config::rows_of_option(flag).at(0);
        command.add_option(
            flag, [&options, flag](const std::string& text) { options.direct.emplace_back(flag, text); },
            option_help(row),
            {.group = group, .value = option_value(row), .repeated = !row.option.second.empty()});
    }
}

}  // namespace hexrelief::cli
