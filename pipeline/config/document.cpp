#include "pipeline/config/document.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pipeline/config/fields.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::config {
namespace {

using Json = nlohmann::ordered_json;

Json json_value(const FieldValue& value) {
    return std::visit(
        [](const auto& v) -> Json {
            if constexpr (std::is_same_v<std::decay_t<decltype(v)>, std::monostate>)
                return nullptr;
            else
                return v;
        },
        value);
}

// Returns the place of a dotted path in nested objects, of which each level is below `level`.
Json::json_pointer place_of(const std::string& path, const std::string& level = "/") {
    return Json::json_pointer(level + replaced(path, '.', level));
}

// Escapes what a terminal obeys, in a JSON string, which escapes the characters below a space alone: C1
// controls (U+007F to U+009F), and the marks of direction and lines among U+2000 to U+207F.
std::string without_controls(const std::string& json) {
    std::string out;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const auto byte = [&](std::size_t k) {
            return static_cast<unsigned char>(i + k < json.size() ? json[i + k] : 0);
        };
        const bool is_mark = byte(0) == 0xe2 && (byte(1) == 0x80 || byte(1) == 0x81) && byte(2) >= 0x8e;
        const unsigned code = byte(0) == 0x7f                     ? 0x7f
                              : byte(0) == 0xc2 && byte(1) < 0xa0 ? byte(1)
                              : is_mark ? 0x2000u + (byte(1) - 0x80u) * 64 + byte(2) - 0x80u
                                        : 0;
        const bool is_obeyed = code > 0 && (code <= 0x200f || (code >= 0x2028 && code <= 0x202e) ||
                                            (code >= 0x2066 && code <= 0x2069));
        if (!is_obeyed) {
            out += json[i];
            continue;
        }
        char text[8];
        std::snprintf(text, sizeof text, "\\u%04x", code);
        out += text;
        i += code < 0x80 ? 0 : code < 0x800 ? 1 : 2;
    }
    return out;
}

std::string yaml_scalar(const Field& field, const FieldValue& value) {
    // A JSON string is also a double-quoted YAML string.
    if (field.type != FieldType::text && field.type != FieldType::file) return format_value(value);
    try {
        return without_controls(Json(std::get<std::string>(value)).dump());
    } catch (const Json::type_error&) {
        throw Error(ErrorKind::usage,
                    field.path + " is '" + std::get<std::string>(value) +
                        "', which is no UTF-8 and cannot stand in a YAML file; rename the file");
    }
}

std::string help_of(const Field& field) {
    return field.help + (field.option.flag.empty() ? "" : "; also " + field.option.flag);
}

// Returns a short text for tables and comments: "2..256 px", "cellular | sequential".
std::string short_type(const Field& field) {
    if (field.type == FieldType::boolean) return "true | false";
    if (field.type == FieldType::text) return "text";
    if (field.type == FieldType::file) return "file";
    if (field.type == FieldType::choice) return joined(field.choices, " | ");
    std::string type =
        format_value(FieldValue(field.range.min)) + " .. " + format_value(FieldValue(field.range.max));
    if (!field.unit.empty()) type += " " + field.unit;
    return type + (field.type == FieldType::integer ? ", integer" : "") +
           (field.is_optional ? ", or null" : "");
}

std::string indent_of(const std::string& path) {
    return std::string(2 * static_cast<std::size_t>(std::ranges::count(path, '.')), ' ');
}

// Returns a Markdown list item with its lines broken between words.
std::string wrapped_item(const std::string& text) {
    constexpr std::size_t kWidth = 132;
    std::istringstream words(text);
    std::string item, line = "-";
    for (std::string word; words >> word;) {
        if (line.size() + 1 + word.size() > kWidth) {
            item += line + "\n";
            line = " ";
        }
        line += " " + word;
    }
    return item + line + "\n";
}

bool is_within(const std::string& path, const Section& section) {
    return path == section.path || path.starts_with(section.path + ".");
}

// Returns the sections that begin between field `from` and the next field, `to`.
std::vector<Section> sections_opened(const std::string& from, const std::string& to) {
    std::vector<Section> opened;
    for (const Section& section : config_sections())
        if (is_within(to, section) && !is_within(from, section)) opened.push_back(section);
    return opened;
}

Json section_schema(const Section& section) {
    return {{"description", section.help},
            {"type", {"object", "null"}},
            {"additionalProperties", false},
            {"properties", Json::object()}};
}

Json field_schema(const Field& field, const FieldValue& initial) {
    Json schema;
    schema["description"] = help_of(field) + (field.unit.empty() ? "" : " [" + field.unit + "]");
    // In the order of FieldType.
    constexpr const char* kTypes[] = {"boolean", "integer", "number", "", "string", "string"};
    const char* const type = kTypes[static_cast<std::size_t>(field.type)];
    if (field.type == FieldType::choice)
        schema["enum"] = field.choices;
    else if (field.is_optional || field.type >= FieldType::text)
        schema["type"] = {type, "null"};
    else
        schema["type"] = type;
    if (field.type == FieldType::integer) {
        schema["minimum"] = static_cast<long long>(field.range.min);
        schema["maximum"] = static_cast<long long>(field.range.max);
    } else if (field.type == FieldType::real) {
        schema["minimum"] = field.range.min;
        schema["maximum"] = field.range.max;
    }
    schema["default"] = json_value(initial);
    return schema;
}

}  // namespace

std::string config_yaml(const Config& config) {
    std::string yaml =
        "# hexrelief configuration. Every key may be left out: the value shown here is then used.\n"
        "# hexrelief run --config FILE reads it, --set key.path=value overrides it, hexrelief config check "
        "FILE checks it.\n";
    std::string current;
    for (const Field& field : config_fields()) {
        const std::string owner = section_of(field.path);
        if (owner != current) {
            for (const Section& section : sections_opened(current, owner)) {
                const std::string indent = indent_of(section.path);
                yaml += "\n" + indent + "# " + section.help + "\n" + indent +
                        section.path.substr(section.path.rfind('.') + 1) + ":\n";
            }
            current = owner;
        }
        const std::string indent = indent_of(field.path);
        yaml += indent + "# " + help_of(field) + "  [" + short_type(field) + "]\n";
        yaml += indent + field.path.substr(field.path.rfind('.') + 1) + ": " +
                yaml_scalar(field, field.get(config)) + "\n";
    }
    return yaml;
}

Json config_json(const Config& config) {
    Json root;
    for (const Field& field : config_fields()) root[place_of(field.path)] = json_value(field.get(config));
    return root;
}

std::string config_schema() {
    Json root = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                 {"title", "hexrelief configuration"},
                 {"type", {"object", "null"}},
                 {"additionalProperties", false},
                 {"properties", Json::object()}};
    const std::string level = "/properties/";
    for (const Section& section : config_sections())
        root[place_of(section.path, level)] = section_schema(section);
    const Config defaults;
    for (const Field& field : config_fields())
        root[place_of(field.path, level)] = field_schema(field, field.get(defaults));
    return root.dump(2) + "\n";
}

std::string config_markdown() {
    const Config defaults;
    std::string text =
        "# Configuration keys\n\n"
        "Written by `hexrelief config show --markdown` from the field table in "
        "`pipeline/config/fields.cpp`.\n"
        "`cmake --build build --target update_keys` writes it anew; a test compares it with the program.\n";
    std::string current;
    for (const Field& field : config_fields()) {
        const std::string section = section_of(field.path);
        if (section != current) {
            for (const Section& opened : sections_opened(current, section))
                text += (opened.path.find('.') == std::string::npos ? "\n## `" : "\n### `") + opened.path +
                        "`\n\n" + opened.help + ".\n";
            text += "\n";
            current = section;
        }
        text += wrapped_item("`" + field.path + "` (default `" + yaml_scalar(field, field.get(defaults)) +
                             "`; " + short_type(field) + "): " + help_of(field));
    }
    return text;
}

}  // namespace hexrelief::config
