// --config and --set, as several commands take them.
#pragma once

#include <string>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/error.h"

namespace hexrelief::config {

struct ConfigOptions {
    std::string file;
    std::vector<std::string> settings;
};

// `base`, then the file, then the settings in their order; finish_config() is still to be called. Throws
// Error(usage), also where a key is set by its old name and by its new one.
Config read_config(const ConfigOptions& options, const Config& base = {});
// What a configuration starts from where neither preset nor file is named. The defaults; for few bytes the
// preset compact, for few vertices its density, lattice and surface.
Config budget_base(const BudgetConfig& budget);
// An option's value for a key, as text or as a number, checked by the field table. Throw Error(usage) naming
// the option.
void apply_option(Config& config, const std::string& option, const std::string& path,
                  const std::string& text);
void apply_option(Config& config, const std::string& option, const std::string& path, double value);
// Checks the rules between fields. Throws Error(usage).
void finish_config(const Config& config);

}  // namespace hexrelief::config
