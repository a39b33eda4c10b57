#include "pipeline/cli/arguments/config_options.h"

#include <cmath>
#include <cstdio>

#include "pipeline/config/options.h"
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

Shard parse_shard(const std::string& text) {
    Shard shard;
    if (text.empty()) return shard;
    int end = 0;
    // NOLINTNEXTLINE(cert-err34-c): six digits are no overflow
    if (std::sscanf(text.c_str(), "%6zu/%6zu%n", &shard.number, &shard.of, &end) != 2 ||
        static_cast<std::size_t>(end) != text.size() || shard.number < 1 || shard.number > shard.of)
        throw Error(ErrorKind::usage, "--shard: must be K/N with K from 1 to N, not '" + text + "'");
    return shard;
}

std::uint64_t parse_memory(const std::string& text) {
    if (text.empty()) return 0;
    double value = 0;
    char unit = 'B', rest = 0;
    // NOLINTNEXTLINE(cert-err34-c): twenty digits are no overflow
    const int read = std::sscanf(text.c_str(), "%20lf%c%c", &value, &unit, &rest);
    static const std::string kUnits = "BKMGT";
    const std::size_t power = kUnits.find(unit);
    const bool is_size = (read == 1 || read == 2) && power != std::string::npos;
    const double bytes = is_size ? std::ldexp(value, static_cast<int>(10 * power)) : 0;
    if (!(bytes >= 1 && bytes < 1e18))
        throw Error(ErrorKind::usage, "--memory: must be like 8G or 512M, not '" + text + "'");
    return static_cast<std::uint64_t>(bytes);
}

}  // namespace hexrelief::cli
