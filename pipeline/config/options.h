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
// A direct option's value for a field, checked by the field table. Throws Error(usage) naming the option.
void apply_option(Config& config, const std::string& option, const std::string& path,
                  const std::string& value);
// Checks the rules between fields. Throws Error(usage).
void finish_config(const Config& config);

// The shortest text that reads back as the same number.
std::string shortest(double value);

}  // namespace hexrelief::config
