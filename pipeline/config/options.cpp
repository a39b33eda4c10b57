#include "pipeline/config/options.h"

#include <algorithm>
#include <stdexcept>

#include "pipeline/config/fields.h"
#include "pipeline/config/presets.h"
#include "pipeline/config/reader.h"

namespace hexrelief::config {

namespace {

const Field& given_field(Config& config, const std::string& path) {
    const Field* field = find_field(path);
    if (!field) throw std::logic_error("no field " + path);
    config.given.insert(path);
    return *field;
}

void refuse(const std::string& option, const std::string& wrong) {
    if (!wrong.empty()) throw Error(ErrorKind::usage, option + " " + wrong);
}

}  // namespace

Config read_config(const std::vector<std::string>& files, const std::vector<std::string>& settings,
                   const Config& base) {
    Config config = base;
    for (const std::string& file : files)
        if (const Preset* preset = find_preset(file))
            apply_yaml(config, preset->yaml, "preset " + preset->name, {});
        else
            apply_config_file(config, file);
    for (const std::string& setting : settings) apply_setting(config, setting);
    return config;
}

Config budget_base(const BudgetConfig& budget) {
    if (budget.vertices == 0 && budget.max_bytes == 0) return {};
    Config config = read_config({"compact"}, {});
    config.given.clear();
    if (budget.max_bytes == 0) config.exporting = {};  // compression does not change the vertices
    config.decisions = {std::string("budget: the preset compact, because none is named") +
                        (budget.max_bytes == 0
                             ? "; files are written as by default, for only the vertices are limited"
                             : "")};
    return config;
}

void apply_option(Config& config, const std::string& option, const std::string& path,
                  const std::string& text) {
    refuse(option, assign_text(config, given_field(config, path), text));
}

void apply_option(Config& config, const std::string& option, const std::string& path, double value) {
    refuse(option, assign_value(config, given_field(config, path), value));
}

void finish_config(const Config& config) {
    check_rules(config, "");
}

}  // namespace hexrelief::config
