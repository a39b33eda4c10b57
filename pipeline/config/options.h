// --config and --set, as several commands take them.
#pragma once

#include <string>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/error.h"

namespace hexrelief {

struct ConfigOptions {
    std::string file;
    std::vector<std::string> settings;
};

// Defaults, then the file, then the settings in their order; finish_config() is still to be called. Throws
// Error(usage), also where a key is set by its old name and by its new one.
Config read_config(const ConfigOptions& options);
// A direct option's value for a field, checked by the field table. Throws Error(usage) naming the option.
void apply_option(Config& config, const std::string& option, const std::string& path,
                  const std::string& value);
// Checks the rules between fields. Throws Error(usage).
void finish_config(const Config& config);

// The shortest text that reads back as the same number.
std::string shortest(double value);

}  // namespace hexrelief
