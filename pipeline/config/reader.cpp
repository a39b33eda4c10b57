#include "pipeline/config/reader.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "pipeline/config/fields.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::config {
namespace {

constexpr std::size_t kMaxConfigBytes = 1 << 20;

// Throws an error of one line: quoted keys and values may hold line breaks.
[[noreturn]] void fail(const std::string& where, const std::string& what) {
    std::string message = where + what;
    std::ranges::replace(message, '\n', ' ');
    throw Error(ErrorKind::usage, message);
}

// Sets the field as assign_text() does, as a value that was given.
std::string assign_given(Config& config, const Field& field, const std::string& text) {
    config.given.insert(field.path);
    return assign_text(config, field, text);
}

struct Reader {
    Config& config;
    std::string origin;
    std::filesystem::path folder;
    std::vector<std::string>* mistakes = nullptr;  // all are collected here; null = the first is thrown

    std::string where(const YAML::Mark& mark) const {
        return origin + ":" + (mark.is_null() ? "1" : std::to_string(mark.line + 1)) + ": ";
    }

    void read_field(const Field& field, const YAML::Node& node) const {
        const std::string place = where(node.Mark()) + field.path + " ";
        if (node.IsMap() || node.IsSequence())
            fail(place, "must be " + describe_type(field) + ", not a list or section");
        const bool quoted = node.Tag() == "!";
        const std::string text = node.IsNull() ? "null" : node.Scalar();
        const bool textual =
            field.type == FieldType::text || field.type == FieldType::file || field.type == FieldType::choice;
        if (quoted && !textual)
            fail(place, "must be " + describe_type(field) + ", not the quoted text '" + text + "'");
        const std::string wrong = assign_given(config, field, text);
        if (!wrong.empty()) fail(place, wrong);
        if (field.type != FieldType::file) return;
        const auto name = std::get<std::string>(field.get(config));
        if (!name.empty() && std::filesystem::path(name).is_relative())
            field.set(config, (folder / name).lexically_normal().string());
    }

    void read_section(const std::string& section, const YAML::Node& node) const {
        if (node.IsNull()) return;
        if (!node.IsMap()) {
            const std::string name = section.empty() ? "the top level" : section;
            fail(where(node.Mark()), name + " must be a section of 'key: value' lines");
        }
        std::set<std::string> seen;
        for (const auto& entry : node) try {
                read_entry(section, entry.first, entry.second, seen);
            } catch (const Error& error) {
                if (mistakes == nullptr) throw;
                mistakes->push_back(error.what());
            }
    }

    void read_entry(const std::string& section, const YAML::Node& name, const YAML::Node& value,
                    std::set<std::string>& seen) const {
        const YAML::Mark mark = name.Mark();
        if (!name.IsScalar()) fail(where(mark), "a key must be a plain name");
        const std::string path = section.empty() ? name.Scalar() : section + "." + name.Scalar();
        if (!seen.insert(path).second) fail(where(mark), "duplicate key '" + path + "'; keep one");
        if (const Field* field = find_field(path))
            read_field(*field, value);
        else if (find_section(path))
            read_section(path, value);
        else
            fail(where(mark), "unknown key '" + path + "'" + suggest_key(path));
    }
};

// Collects the positions at which documents begin.
class DocumentStarts : public YAML::EventHandler {
  public:
    std::vector<YAML::Mark> marks;

    void OnDocumentStart(const YAML::Mark& mark) override { marks.push_back(mark); }
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
    void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
    void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
    void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                         YAML::EmitterStyle::value) override {}
    void OnSequenceEnd() override {}
    void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                    YAML::EmitterStyle::value) override {}
    void OnMapEnd() override {}
};

// Returns the text's only document; null if the text has no document.
YAML::Node load_document(const Reader& reader, const std::string& text) {
    std::istringstream in(text);
    YAML::Parser parser(in);
    DocumentStarts starts;
    // Does not read all documents: at a comma the parser of yaml-cpp 0.7 begins documents without end
    // and does not advance.
    const bool two = parser.HandleNextDocument(starts) && parser.HandleNextDocument(starts);
    if (two && starts.marks[0].pos == starts.marks[1].pos)
        fail(reader.where(starts.marks[0]), "not valid YAML: nothing can begin so");
    if (two) fail(reader.origin + ": ", "holds more than one YAML document; keep one");
    return YAML::Load(text);
}

void read_document(const Reader& reader, const std::string& text) {
    try {
        reader.read_section("", load_document(reader, text));
    } catch (const YAML::Exception& e) {
        fail(reader.where(e.mark), "not valid YAML: " + readers::codec::printable(e.msg, 200));
    }
    check_rules(reader.config, reader.origin + ": ");
}

std::string text_of(const std::filesystem::path& path) {
    std::error_code ignored;
    const bool regular = std::filesystem::is_regular_file(path, ignored);  // opening a pipe would wait
    std::ifstream file(regular ? path : std::filesystem::path(), std::ios::binary);
    if (!file) fail("", "cannot read the configuration file " + path.string() + "; check its name");
    std::string text(kMaxConfigBytes + 1, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxConfigBytes)
        fail(path.string(), ": larger than 1 MiB; this is not a configuration file");
    if (text.find('\0') != std::string::npos)
        fail(path.string(), ": holds binary data; a configuration is YAML text");
    return text;
}

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

void apply_yaml(Config& config, const std::string& text, const std::string& origin,
                const std::filesystem::path& folder) {
    read_document({config, origin, folder}, text);
}

void apply_config_file(Config& config, const std::filesystem::path& path) {
    apply_yaml(config, text_of(path), path.string(), path.parent_path());
}

std::vector<std::string> mistakes_in(const std::filesystem::path& path) {
    Config config;
    std::vector<std::string> mistakes;
    try {
        read_document({config, path.string(), path.parent_path(), &mistakes}, text_of(path));
    } catch (const Error& error) {
        mistakes.push_back(error.what());
    }
    return mistakes;
}

void apply_setting(Config& config, const std::string& setting) {
    const std::size_t equals = setting.find('=');
    const std::string place = "--set " + setting + ": ";
    if (equals == std::string::npos || equals == 0) fail(place, "write it as key.path=value");
    const std::string path = setting.substr(0, equals);
    const Field* field = find_field(path);
    if (!field && find_section(path)) fail(place, "'" + path + "' is a section; set one of its keys");
    if (!field)
        fail(place,
             "unknown key '" + path + "'" + suggest_key(path) + "; 'hexrelief config show' lists all keys");
    const std::string wrong = assign_given(config, *field, setting.substr(equals + 1));
    if (!wrong.empty()) fail(place, field->path + " " + wrong);
}

std::string describe_type(const Field& field) {
    if (field.type == FieldType::choice) return "one of " + joined(field.choices, ", ");
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
