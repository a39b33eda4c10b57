// The field table: every parameter once, with its YAML path, unit, range and meaning.
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/config/config.h"

namespace hexrelief::config {

enum class FieldType { boolean, integer, optional_integer, real, optional_real, choice, text };

// monostate = null: an optional value that is not given.
using FieldValue = std::variant<std::monostate, bool, long long, double, std::string>;

struct Field {
    std::string path;  // "mesh.spacing_px"
    std::string unit;  // "px"; empty = none
    std::string help;  // one line, no full stop
    FieldType type = FieldType::real;
    double min = 0;  // inclusive, numbers only
    double max = 0;
    std::vector<std::string> choices;  // in the order of the enum's values
    std::function<FieldValue(const Config&)> get;
    std::function<void(Config&, const FieldValue&)> set;  // wants a value of the field's type and range
};

struct Section {
    std::string path;  // "mesh", "export.draco"
    std::string help;
};

// In the order in which they are written; a section's fields are neighbours.
const std::vector<Field>& config_fields();
const std::vector<Section>& config_sections();

// nullptr where there is none.
const Field* find_field(const std::string& path);
const Section* find_section(const std::string& path);

// "a number from 2 to 256 px", "one of cellular, sequential".
std::string describe_type(const Field& field);
// As YAML and --set read it: "6", "true", "null", "cellular"; numbers in the shortest form that reads back
// the same.
std::string format_value(const FieldValue& value);

// Sets a field from its text. Returns what is wrong ("must be ..., not 'x'"), empty where all is well.
std::string assign_text(Config& config, const Field& field, const std::string& text);

// " (did you mean 'mesh.spacing_px'?)" for a path that is near a field's or a section's, else empty.
std::string suggest_key(const std::string& path);

// Rules between fields. Throws Error(usage) with origin in front.
void check_rules(const Config& config, const std::string& origin);

}  // namespace hexrelief::config
