// Configuration from YAML files and --set, checked against the field table.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/config/config.h"

namespace hexrelief::config {

// Changes in config what the YAML text sets; the rest stays. origin names the text in errors: "FILE:LINE:
// ...". Relative file names in it are taken from `folder`. Throws Error(usage): not YAML, unknown or
// duplicate key, wrong type, out of range. A key by an older name (old_names.h) is read, and config.warnings
// says so; both names in one text are a duplicate key.
void apply_yaml(Config& config, const std::string& text, const std::string& origin,
                const std::filesystem::path& folder);

// apply_yaml of a file. Throws Error(usage) where it cannot be read.
void apply_config_file(Config& config, const std::filesystem::path& path);

// "mesh.spacing_px=4". Older names are read with a warning as well. Throws Error(usage).
void apply_setting(Config& config, const std::string& setting);

}  // namespace hexrelief::config
