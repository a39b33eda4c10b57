// Reads the configuration from YAML files and --set, checked against the field table.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/config/config.h"

namespace hexrelief::config {

// Sets the values that the YAML text gives. origin names the text in errors: "FILE:LINE: ...". Relative file
// names in the text are relative to `folder`. Throws Error(usage) for invalid YAML, an unknown or duplicate
// key, a wrong type and a value out of range.
void apply_yaml(Config& config, const std::string& text, const std::string& origin,
                const std::filesystem::path& folder);

// Applies a YAML file. Throws as apply_yaml(), and Error(usage) if the file cannot be read.
void apply_config_file(Config& config, const std::filesystem::path& path);

// Returns all mistakes in a YAML file, in the order of its lines, in the words of apply_config_file(). What
// hides all else is alone: a file that cannot be read or is no YAML.
std::vector<std::string> mistakes_in(const std::filesystem::path& path);

// Applies "mesh.spacing_px=4". Older names are read with a warning, too. Throws Error(usage).
void apply_setting(Config& config, const std::string& setting);

}  // namespace hexrelief::config
