// The field table's values as text, and what is wrong with them.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "pipeline/config/fields.h"
#include "pipeline/config/suggest.h"
#include "pipeline/data/error.h"

namespace hexrelief::config {
namespace {

std::string format_number(double value) {
    char buffer[40];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
    return {buffer, end};
}

// Whole text as a number, with an optional plus sign; false where it is not one.
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

}  // namespace

std::string describe_type(const Field& field) {
    const std::string unit = field.unit.empty() ? "" : " " + field.unit;
    const std::string range = " from " + format_number(field.min) + " to " + format_number(field.max) + unit;
    switch (field.type) {
        case FieldType::boolean:
            return "true or false";
        case FieldType::integer:
            return "an integer" + range;
        case FieldType::optional_integer:
            return "null or an integer" + range;
        case FieldType::real:
            return "a number" + range;
        case FieldType::optional_real:
            return "null or a number" + range;
        case FieldType::text:
            return "a text";
        case FieldType::choice:
            break;
    }
    std::string names;
    for (const std::string& name : field.choices) names += (names.empty() ? "" : ", ") + name;
    return "one of " + names;
}

std::string format_value(const FieldValue& value) {
    if (const auto* b = std::get_if<bool>(&value)) return *b ? "true" : "false";
    if (const auto* i = std::get_if<long long>(&value)) return std::to_string(*i);
    if (const auto* d = std::get_if<double>(&value)) return format_number(*d);
    if (const auto* s = std::get_if<std::string>(&value)) return *s;
    return "null";
}

std::string assign_text(Config& config, const Field& field, const std::string& text) {
    const std::string complaint = "must be " + describe_type(field) + ", not '" + text + "'";
    const auto in_range = [&](double v) { return v >= field.min && v <= field.max; };
    switch (field.type) {
        case FieldType::boolean: {
            const bool yes = text == "true" || text == "True" || text == "yes" || text == "on";
            const bool no = text == "false" || text == "False" || text == "no" || text == "off";
            if (!yes && !no) return complaint;
            field.set(config, yes);
            return {};
        }
        case FieldType::optional_integer:
            if (is_null(text)) {
                field.set(config, {});
                return {};
            }
            [[fallthrough]];
        case FieldType::integer: {
            long long value = 0;
            if (!parse_number(text, value) || !in_range(static_cast<double>(value))) return complaint;
            field.set(config, value);
            return {};
        }
        case FieldType::optional_real:
            if (is_null(text)) {
                field.set(config, {});
                return {};
            }
            [[fallthrough]];
        case FieldType::real: {
            double value = 0;
            if (!parse_number(text, value) || !in_range(value)) return complaint;
            field.set(config, value);
            return {};
        }
        case FieldType::choice: {
            if (std::find(field.choices.begin(), field.choices.end(), text) == field.choices.end()) {
                const std::string near = nearest_name(text, field.choices);
                return complaint + (near.empty() ? "" : " (did you mean '" + near + "'?)");
            }
            field.set(config, text);
            return {};
        }
        case FieldType::text:
            field.set(config, is_null(text) ? std::string() : text);
            return {};
    }
    return complaint;
}

std::string suggest_key(const std::string& path) {
    // The right name in the wrong section comes first: "spacing_px" or "run.spacing_px" for
    // "mesh.spacing_px".
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
    if (config.disparity.block_size_px % 2 == 0)
        fail("disparity.block_size_px must be odd, not " + std::to_string(config.disparity.block_size_px));
    if (config.mesh.alpha_final > config.mesh.alpha_init)
        fail("mesh.alpha_final must not be above mesh.alpha_init");
    if (config.mesh.sigma_final > config.mesh.sigma_init)
        fail("mesh.sigma_final must not be above mesh.sigma_init");
    if (config.disparity.p1 > 0 && config.disparity.p2 > 0 && config.disparity.p2 <= config.disparity.p1)
        fail("disparity.p2 must be above disparity.p1");
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
