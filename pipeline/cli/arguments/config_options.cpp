#include "pipeline/cli/arguments/config_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

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

Shard parse_shard(const std::string& text) {
    if (text.empty()) return {};
    const std::size_t slash = std::min(text.find('/'), text.size() - 1);
    const auto number = whole_number(text.substr(0, slash)), of = whole_number(text.substr(slash + 1));
    if (!number || !of || *number < 1 || *number > *of)
        throw Error(ErrorKind::usage, "--shard: must be K/N with K from 1 to N, not '" + text + "'");
    return {*number, *of};
}

std::uint64_t parse_memory(const std::string& text) {
    if (text.empty()) return 0;
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, failure] = std::from_chars(text.data(), end, value);
    const std::size_t power = rest == end ? 0 : std::string("BKMGT").find(*rest);
    const bool is_size = failure == std::errc() && end - rest <= 1 && power != std::string::npos;
    const double bytes = is_size ? std::ldexp(value, static_cast<int>(10 * power)) : 0;
    if (!(bytes >= 1 && bytes < 1e18))
        throw Error(ErrorKind::usage, "--memory: must be like 8G or 512M, not '" + text + "'");
    return static_cast<std::uint64_t>(bytes);
}

}  // namespace hexrelief::cli
