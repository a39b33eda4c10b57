// The field table: every parameter once, with its YAML path, unit, range and meaning.
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/value_range.h"

namespace hexrelief::config {

// A file's name in a YAML file is relative to that file.
enum class FieldType { boolean, integer, optional_integer, real, optional_real, choice, text, file };

// monostate = null: an optional value that is not given.
using FieldValue = std::variant<std::monostate, bool, long long, double, std::string>;

// The option of the command line that sets a field (key_options.h).
struct FieldOption {
    std::string flag = {};   // "--fov-x"; empty = none
    std::string value = {};  // what help calls the value: "DEG"; empty for booleans and choices
};

struct Field {
    std::string path;  // "mesh.spacing_px"
    std::string unit;  // "px"; empty = none
    std::string help;  // one line, no full stop; up to the first semicolon also the option's
    FieldType type = FieldType::real;
    ValueRange range;                  // of numbers
    std::vector<std::string> choices;  // in the order of the enum's values
    FieldOption option;
    std::function<FieldValue(const Config&)> get;
    std::function<void(Config&, const FieldValue&)> set;  // wants a value of the field's type and range
};

struct Section {
    std::string path;  // "mesh", "export.draco"
    std::string help;
    std::string file = {};  // the option of the file without which the section's options have no meaning
};

// In the order in which they are written; a section's fields are neighbours.
const std::vector<Field>& config_fields();
const std::vector<Section>& config_sections();

// nullptr where there is none.
const Field* find_field(const std::string& path);
const Section* find_section(const std::string& path);
std::string section_of(const std::string& path);  // "mesh" of "mesh.spacing_px"

// "a number from 2 to 256 px", "one of cellular, sequential".
std::string describe_type(const Field& field);
// As YAML and --set read it: "6", "true", "null", "cellular"; numbers in the shortest form that reads back
// the same.
std::string format_value(const FieldValue& value);

// Set a field from a value or from its text. Return what is wrong ("must be ..., not 'x'"), empty if nothing.
std::string assign_value(Config& config, const Field& field, const FieldValue& value);
std::string assign_text(Config& config, const Field& field, const std::string& text);

// " (did you mean 'mesh.spacing_px'?)" for a path that is near a field's or a section's, else empty.
std::string suggest_key(const std::string& path);

// Rules between fields. Throws Error(usage) with origin in front.
void check_rules(const Config& config, const std::string& origin);

}  // namespace hexrelief::config
