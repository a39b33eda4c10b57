// Reads a configuration from a file or preset and settings on top of it.
#pragma once

#include <string>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/error.h"

namespace hexrelief::config {

// Returns `base` with the values of each file, or of the preset of that name, and then of the settings
// ("key.path=value"), in their order. Call finish_config() afterwards. Throws Error(usage).
Config read_config(const std::vector<std::string>& files, const std::vector<std::string>& settings,
                   const Config& base = {});
// Returns the configuration to start from if neither preset nor file is named: the defaults; for a limit on
// bytes the preset compact; for a limit on vertices compact with the default export settings.
Config budget_base(const BudgetConfig& budget);
// Set a key from an option's text or number, checked by the field table. Throw Error(usage)
// that names the option.
void apply_option(Config& config, const std::string& option, const std::string& path,
                  const std::string& text);
void apply_option(Config& config, const std::string& option, const std::string& path, double value);
// Checks the rules between fields. Throws Error(usage).
void finish_config(const Config& config);

}  // namespace hexrelief::config
