#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pipeline/batch/manifest_rows.h"
#include "pipeline/data/nesting.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::batch {
namespace {

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

}  // namespace

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

}  // namespace hexrelief::batch
