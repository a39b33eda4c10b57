// The configuration written out: YAML, JSON, JSON Schema, Markdown.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "pipeline/config/config.h"

namespace hexrelief::config {

// Fully commented YAML that reads back as the same configuration.
std::string config_yaml(const Config& config);
// Sections as nested objects, all keys.
nlohmann::ordered_json config_json(const Config& config);
// JSON Schema, draft 2020-12, for editors.
std::string config_schema();
// config/KEYS.md, whole: all keys by section, each with default, range and meaning; lines of at most 132
// columns.
std::string config_markdown();

}  // namespace hexrelief::config
