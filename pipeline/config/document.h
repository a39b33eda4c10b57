// Writes the configuration as YAML, JSON, JSON Schema and Markdown.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "pipeline/config/config.h"

namespace hexrelief::config {

// Returns fully commented YAML that reads back as the same configuration.
std::string config_yaml(const Config& config);
// Returns all keys, sections as nested objects.
nlohmann::ordered_json config_json(const Config& config);
// Returns a JSON Schema, draft 2020-12, for editors.
std::string config_schema();
// Returns the text of config/KEYS.md: all keys by section, each with default, range and meaning.
std::string config_markdown();

}  // namespace hexrelief::config
