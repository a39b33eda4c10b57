// Converts the field table's values from and to text, and checks them.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "pipeline/config/fields.h"
#include "pipeline/data/error.h"

namespace hexrelief::config {
namespace {

std::string format_number(double value) {
    char buffer[40];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
    return {buffer, end};
}

// Reads the whole text as a number, with an optional plus sign; false if it is not a number.
template <typename T>
bool parse_number(const std::string& text, T& value) {
    const char* first = text.data();
    const char* const last = first + text.size();
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') ++first;
    const auto [end, error] = std::from_chars(first, last, value);
    return error == std::errc() && end == last && first != last;
}

bool is_null(const std::string& text) {
    return text.empty() || text == "null" || text == "~" || text == "Null" || text == "NULL";
}

template <typename Number>
std::optional<FieldValue> number_of(const std::string& text) {
    Number value = 0;
    return parse_number(text, value) ? std::optional<FieldValue>(value) : std::nullopt;
}

// Returns none if the text has another type.
std::optional<FieldValue> value_of(const Field& field, const std::string& text) {
    if (field.is_optional && is_null(text)) return FieldValue();
    if (field.type == FieldType::boolean) {
        if (text == "true" || text == "True" || text == "yes" || text == "on") return true;
        if (text == "false" || text == "False" || text == "no" || text == "off") return false;
        return std::nullopt;
    }
    if (field.type == FieldType::integer) return number_of<long long>(text);
    if (field.type == FieldType::real) return number_of<double>(text);
    return is_null(text) && field.type != FieldType::choice ? std::string() : text;
}

bool takes(const Field& field, const FieldValue& value) {
    if (std::holds_alternative<std::monostate>(value)) return field.is_optional;
    const auto* const integer = std::get_if<long long>(&value);
    const auto* const real = std::get_if<double>(&value);
    if (field.type == FieldType::boolean) return std::holds_alternative<bool>(value);
    if (field.type == FieldType::integer) return integer && field.range.holds(static_cast<double>(*integer));
    if (field.type == FieldType::real) return real && field.range.holds(*real);
    if (field.type == FieldType::choice)
        return std::ranges::find(field.choices, format_value(value)) != field.choices.end();
    return std::holds_alternative<std::string>(value);
}

std::string complaint(const Field& field, const std::string& text) {
    const std::string near = nearest_name(text, field.choices);
    return "must be " + describe_type(field) + ", not '" + text + "'" +
           (near.empty() ? "" : " (did you mean '" + near + "'?)");
}

}  // namespace

std::string describe_type(const Field& field) {
    if (field.type == FieldType::choice) {
        std::string names;
        for (const std::string& name : field.choices) names += (names.empty() ? "" : ", ") + name;
        return "one of " + names;
    }
    // In the order of FieldType.
    constexpr const char* kTypes[] = {"true or false", "an integer", "a number", "", "a text", "a file name"};
    const std::string type =
        (field.is_optional ? "null or " : "") + std::string(kTypes[static_cast<std::size_t>(field.type)]);
    if (!type.ends_with("integer") && !type.ends_with("number")) return type;
    return type + " from " + format_number(field.range.min) + " to " + format_number(field.range.max) +
           (field.unit.empty() ? "" : " " + field.unit);
}

std::string format_value(const FieldValue& value) {
    if (const auto* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
    if (const auto* i = std::get_if<long long>(&value)) return std::to_string(*i);
    if (const auto* d = std::get_if<double>(&value)) return format_number(*d);
    if (const auto* s = std::get_if<std::string>(&value)) return *s;
    return "null";
}

std::string assign_value(Config& config, const Field& field, const FieldValue& value) {
    if (!takes(field, value)) return complaint(field, format_value(value));
    field.set(config, value);
    return {};
}

std::string assign_text(Config& config, const Field& field, const std::string& text) {
    const std::optional<FieldValue> value = value_of(field, text);
    if (!value || !takes(field, *value)) return complaint(field, text);
    field.set(config, *value);
    return {};
}

std::string suggest_key(const std::string& path) {
    // The right name in the wrong section comes first: "spacing_px"
    // or "run.spacing_px" for "mesh.spacing_px".
    const std::string last = path.substr(path.rfind('.') + 1);
    std::vector<std::string> paths;
    for (const Field& field : config_fields()) {
        if (last.size() > 3 && field.path.substr(field.path.rfind('.') + 1) == last)
            return " (did you mean '" + field.path + "'?)";
        paths.push_back(field.path);
    }
    for (const Section& section : config_sections()) paths.push_back(section.path);
    const std::string near = nearest_name(path, paths);
    return near.empty() ? "" : " (did you mean '" + near + "'?)";
}

void check_rules(const Config& config, const std::string& origin) {
    const auto fail = [&](const std::string& what) { throw Error(ErrorKind::usage, origin + what); };
    if (const std::string wrong = stages::wrong_disparity_config(config.disparity); !wrong.empty())
        fail(wrong);
    if (config.mesh.alpha_final > config.mesh.alpha_init)
        fail("mesh.alpha_final must not be above mesh.alpha_init");
    if (config.mesh.sigma_final > config.mesh.sigma_init)
        fail("mesh.sigma_final must not be above mesh.sigma_init");
    const BudgetConfig& budget = config.budget;
    if ((budget.vertices > 0) + (budget.max_bytes > 0) + (budget.max_error_px > 0) > 1)
        fail("budget.vertices, budget.max_bytes and budget.max_error_px exclude each other; give one");
    const CalibrationConfig& camera = config.input.calibration;
    if (!std::isnan(camera.focal_px) && !std::isnan(camera.fov_x_deg))
        fail("input.calibration.focal_px and fov_x_deg exclude each other; give one");
    if (const std::string wrong = readers::wrong_depth_config(config.input.depth); !wrong.empty())
        fail(wrong);
}

}  // namespace hexrelief::config
