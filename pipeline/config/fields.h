// The field table: every parameter once, with its YAML path, unit, range and meaning.
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/value_range.h"

namespace hexrelief::config {

// Returns the Levenshtein distance, in which a swap of neighbouring letters is one step.
int edit_distance(const std::string& a, const std::string& b);

// Returns the nearest candidate, the first of equals; empty if none is near enough to be meant.
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

// A file name in a YAML file is relative to that file.
enum class FieldType { boolean, integer, real, choice, text, file };

// monostate = null: an optional value that is not given.
using FieldValue = std::variant<std::monostate, bool, long long, double, std::string>;

// The option of the command line that sets a field (options.h).
struct FieldOption {
    std::string flag = {};    // "--fov-x"; empty = none
    std::string value = {};   // name of the value in the help: "DEG"; empty for booleans and choices
    std::string second = {};  // path of the field that the option sets if it is given a second time
};

struct Field {
    std::string path;  // "mesh.spacing_px"
    std::string unit;  // "px"; empty = none
    std::string help;  // one line, no full stop; the option's help ends at the first semicolon
    FieldType type = FieldType::real;
    ValueRange range;                  // for numbers
    std::vector<std::string> choices;  // in the order of the enum's values
    FieldOption option;
    std::function<FieldValue(const Config&)> get;
    std::function<void(Config&, const FieldValue&)> set;  // the value must have the field's type and range
    bool is_optional = false;                             // null = not given
};

struct Section {
    std::string path;  // "mesh", "export.draco"
    std::string help;
    std::string file = {};  // option of the file that the section's options need
};

// Return the table in the order of writing; a section's fields are neighbours.
const std::vector<Field>& config_fields();
const std::vector<Section>& config_sections();

// Return null if there is no such field or section.
const Field* find_field(const std::string& path);
const Section* find_section(const std::string& path);
std::string section_of(const std::string& path);  // "mesh" of "mesh.spacing_px"

// Returns "a number from 2 to 256 px", "one of cellular, sequential".
std::string describe_type(const Field& field);
// Returns the text that YAML and --set read: "6", "true", "null", "cellular"; numbers in the shortest form
// that reads back as the same number.
std::string format_value(const FieldValue& value);

// Set a field from a value or from its text. Return the mistake ("must be ..., not 'x'"); empty = none.
std::string assign_value(Config& config, const Field& field, const FieldValue& value);
std::string assign_text(Config& config, const Field& field, const std::string& text);

// Returns " (did you mean 'mesh.spacing_px'?)" for a path that is near a field's or a section's, else empty.
std::string suggest_key(const std::string& path);

// Checks the rules between fields. Throws Error(usage) with `origin` in front.
void check_rules(const Config& config, const std::string& origin);

}  // namespace hexrelief::config
