#include "pipeline/batch/manifest_rows.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string_view>

#include "pipeline/data/error.h"
#include "pipeline/data/nesting.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::batch {
namespace {

struct CsvRecord {
    int line = 0;  // of its first cell
    std::vector<std::string> cells;
    bool is_closed = true;  // false: a quote was opened and never closed
};

class CsvReader {
  public:
    explicit CsvReader(std::string_view text) : rest_(text) {
        if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);  // a byte order mark
    }

    std::optional<CsvRecord> next() {
        while (!rest_.empty() && (rest_.front() == '\n' || rest_.front() == '\r')) take();
        if (rest_.empty()) return std::nullopt;
        CsvRecord record{line_, {}, true};
        do {
            record.cells.push_back(cell(record.is_closed));
        } while (took(','));
        took('\r');
        took('\n');
        return record;
    }

  private:
    char take() {
        const char first = rest_.front();
        rest_.remove_prefix(1);
        line_ += first == '\n';
        return first;
    }
    bool took(char wanted) {
        if (!rest_.starts_with(wanted)) return false;
        take();
        return true;
    }
    std::string cell(bool& is_closed) {
        std::string text;
        if (!took('"')) {
            while (!rest_.empty() && std::string_view(",\r\n").find(rest_.front()) == std::string_view::npos)
                text += take();
            return text;
        }
        for (;;) {
            if (rest_.empty()) {
                is_closed = false;
                return text;
            }
            const char letter = take();
            if (letter == '"' && !took('"')) return text;
            text += letter;
        }
    }

    std::string_view rest_;
    int line_ = 1;
};

using Json = nlohmann::ordered_json;
constexpr int kDeepestSection = 4;

// Adds the values of a section and of the sections in it. Returns the error; empty if there is none.
std::string append_values(const Json& section, const std::string& above, int depth, ManifestRow& row) {
    if (depth > kDeepestSection) return readers::codec::excerpt(above) + " goes too deep";
    for (const auto& [name, value] : section.items()) {
        const std::string key = above.empty() ? name : above + "." + name;
        if (value.is_null()) continue;
        if (value.is_object()) {
            if (std::string wrong = append_values(value, key, depth + 1, row); !wrong.empty()) return wrong;
        } else if (value.is_array()) {
            std::string list;
            for (const Json& part : value) {
                if (!part.is_string())
                    return readers::codec::excerpt(key) + " must be one value, or a list of texts";
                list += (list.empty() ? "" : ",") + part.get<std::string>();
            }
            row.values.emplace_back(key, list);
        } else {
            row.values.emplace_back(key, value.is_string() ? value.get<std::string>() : value.dump());
        }
    }
    return {};
}

std::string read_json_row(const std::string& line, ManifestRow& row) {
    if (is_nested_too_deeply(line)) return "not valid JSON: its brackets are nested too deeply";
    try {
        const Json json = Json::parse(line);
        if (!json.is_object()) return "not a JSON object: write {\"left\": ..., \"right\": ...}";
        return append_values(json, "", 1, row);
    } catch (const Json::exception& error) {
        const std::string told = error.what();  // "[json.exception.parse_error.101] parse error at ..."
        return "not valid JSON: " + told.substr(std::min(told.size(), told.find("] ") + 2));
    }
}

constexpr int kDeepestYamlSection = 4;
// Most values of one row: aliases could multiply them without limit.
constexpr std::size_t kMostValues = 1000;

[[noreturn]] void refuse_yaml(const std::string& origin, const std::string& why) {
    throw Error(ErrorKind::usage, origin + ": " + why);
}

// Refuses a second document, because yaml-cpp reads only the first one and ignores the others.
void refuse_second_document(const std::string& text, const std::string& origin) {
    std::istringstream lines(text);
    bool has_begun = false;
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        if (line.starts_with("---")) {
            if (has_begun)
                refuse_yaml(origin + ":" + std::to_string(number), "holds more than one YAML document");
            has_begun = true;
        } else if (line.find_first_not_of(" \t\r") != std::string::npos && !line.starts_with('#')) {
            has_begun = true;
        }
    }
}

// Puts the defaults before the row's values. A row's value replaces the default of its key. A key that the
// row itself gives twice stays twice, and is refused as in other manifests.
void begin_with_defaults(const ManifestRow& defaults, ManifestRow& row) {
    auto own = std::exchange(row.values, defaults.values);
    for (auto& value : row.values) {
        const auto same =
            std::ranges::find_if(own, [&](const auto& pair) { return pair.first == value.first; });
        if (same == own.end()) continue;
        value = *same;
        own.erase(same);
    }
    row.values.insert(row.values.end(), own.begin(), own.end());
}

// Adds the values of a section and of the sections in it. Returns the error; empty if there is none.
std::string append_section(const YAML::Node& section, const std::string& above, int depth, ManifestRow& row) {
    if (depth > kDeepestYamlSection) return readers::codec::excerpt(above) + " goes too deep";
    for (const auto& entry : section) {
        if (!entry.first.IsScalar()) return "a key must be a plain name";
        const std::string key = (above.empty() ? "" : above + ".") + entry.first.Scalar();
        const YAML::Node& value = entry.second;
        if (row.values.size() > kMostValues) return "more than " + std::to_string(kMostValues) + " values";
        if (value.IsNull()) continue;
        if (value.IsMap()) {
            if (std::string wrong = append_section(value, key, depth + 1, row); !wrong.empty()) return wrong;
        } else if (value.IsSequence()) {
            std::string list;
            for (const YAML::Node& part : value) {
                if (!part.IsScalar())
                    return readers::codec::excerpt(key) + " must be one value, or a list of texts";
                list += (list.empty() ? "" : ",") + part.Scalar();
            }
            row.values.emplace_back(plain_key(key), list);
        } else {
            row.values.emplace_back(plain_key(key), value.Scalar());
        }
    }
    return {};
}

}  // namespace

std::vector<ManifestRow> csv_rows(const std::string& text, const std::string& origin) {
    CsvReader reader(text);
    const std::optional<CsvRecord> header = reader.next();
    if (!header || !header->is_closed)
        throw Error(ErrorKind::usage, origin + ": its first line has to name the columns: left,right,...");
    std::vector<ManifestRow> rows;
    while (const std::optional<CsvRecord> record = reader.next()) {
        ManifestRow row{origin + ":" + std::to_string(record->line), {}, {}};
        const std::size_t cells = record->cells.size(), columns = header->cells.size();
        if (!record->is_closed)
            row.wrong = "a quote is opened and never closed";
        else if (cells > columns)
            row.wrong = std::to_string(cells) + " cells, but the header names " + std::to_string(columns);
        for (std::size_t i = 0; i < std::min(cells, columns); ++i)
            if (!record->cells[i].empty()) row.values.emplace_back(header->cells[i], record->cells[i]);
        rows.push_back(std::move(row));
    }
    return rows;
}

std::vector<ManifestRow> json_rows(const std::string& text, const std::string& origin) {
    std::vector<ManifestRow> rows;
    std::istringstream lines(text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
        ManifestRow row{origin + ":" + std::to_string(number), {}, {}};
        row.wrong = read_json_row(line, row);
        rows.push_back(std::move(row));
    }
    return rows;
}

std::vector<ManifestRow> yaml_rows(const std::string& text, const std::string& origin) {
    refuse_second_document(text, origin);
    try {
        const YAML::Node document = YAML::Load(text);
        YAML::Node list = document;
        ManifestRow defaults;
        if (document.IsMap()) {
            for (const auto& entry : document) {
                const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
                if (key != "rows" && key != "defaults")
                    refuse_yaml(origin + ":" + std::to_string(entry.first.Mark().line + 1),
                                "unknown key " + readers::codec::excerpt(key) +
                                    "; a manifest holds 'rows' and 'defaults'");
            }
            list.reset(document["rows"]);
            const YAML::Node common = document["defaults"];
            if (common && !common.IsMap() && !common.IsNull())
                refuse_yaml(origin, "'defaults' must be a section of 'key: value' lines");
            if (common && common.IsMap()) defaults.wrong = append_section(common, "", 1, defaults);
            if (!defaults.wrong.empty()) refuse_yaml(origin, "defaults: " + defaults.wrong);
        }
        if (!list || !list.IsSequence())
            refuse_yaml(origin, "must be a list of rows, '- left: ...', or hold one as 'rows'");
        std::vector<ManifestRow> rows;
        for (const YAML::Node& node : list) {
            ManifestRow row{origin + ":" + std::to_string(node.Mark().line + 1), {}, {}};
            row.wrong = node.IsMap() ? append_section(node, "", 1, row) : "a row must be 'key: value' lines";
            begin_with_defaults(defaults, row);
            rows.push_back(std::move(row));
        }
        return rows;
    } catch (const YAML::Exception& error) {
        refuse_yaml(origin + ":" + std::to_string(error.mark.is_null() ? 1 : error.mark.line + 1),
                    "not valid YAML: " + readers::codec::printable(error.msg, 200));
    }
}

}  // namespace hexrelief::batch
