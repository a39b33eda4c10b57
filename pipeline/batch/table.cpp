#include "pipeline/batch/table.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "pipeline/data/number_text.h"
#include "pipeline/job/stamp/stamp.h"

namespace hexrelief::batch {
namespace {

using Json = nlohmann::ordered_json;
using Values = std::vector<std::pair<std::string, std::string>>;

std::string json_text(const Json& json) {
    return json.is_string() ? json.get<std::string>()
                            : json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json report_of(const TableRow& row) {
    const bool has_report =
        row.result.outcome == UnitOutcome::done || row.result.outcome == UnitOutcome::up_to_date;
    if (!has_report || row.report.empty()) return nullptr;
    return job::read_json(row.report);
}

bool is_list_of_texts(const Json& json) {
    return json.is_array() && std::ranges::all_of(json, [](const Json& part) { return part.is_string(); });
}

void flatten(const Json& json, const std::string& key, Values& values) {
    if (json.is_null()) return;
    const std::string below = key.empty() ? "" : key + ".";
    if (is_list_of_texts(json)) {
        values.emplace_back(key,
                            joined(json, "; ", [](const Json& part) { return part.get<std::string>(); }));
    } else if (json.is_array()) {
        for (std::size_t i = 0; i < json.size(); ++i) {
            const bool is_named = json[i].is_object() && json[i].contains("name");
            Json part = json[i];
            if (is_named) part.erase("name");
            flatten(part, below + (is_named ? json_text(json[i]["name"]) : std::to_string(i)), values);
        }
    } else if (json.is_object()) {
        for (const auto& [name, value] : json.items()) flatten(value, below + name, values);
    } else {
        values.emplace_back(key, json_text(json));
    }
}

std::string cell(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    return "\"" + replaced(text, '"', "\"\"") + "\"";
}

class Columns {
  public:
    std::size_t at(const std::string& name) {
        const auto [known, is_new] = numbers_.try_emplace(name, names_.size());
        if (is_new) names_.push_back(name);
        return known->second;
    }
    const std::vector<std::string>& names() const { return names_; }

  private:
    std::map<std::string, std::size_t> numbers_;
    std::vector<std::string> names_;
};

// Spreadsheets run a cell that begins with one of these; a leading apostrophe makes it text for them.
std::string inert(const std::string& text) {
    const bool is_number = !text.empty() && text.find_first_not_of("+-.0123456789e") == std::string::npos;
    const bool is_run = !text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos;
    return is_run && !is_number ? "'" + text : text;
}

std::string csv_line(const std::vector<std::string>& cells) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) line += (i > 0 ? "," : "") + cell(inert(cells[i]));
    return line + "\n";
}

constexpr std::size_t kBarWidth = 20;

std::string event_text(const Json& json) {
    return json_text(json) + "\n";
}

std::string clock_text(double seconds) {
    const long long whole = static_cast<long long>(seconds + 0.5);
    char text[48];
    if (whole < 3600)
        std::snprintf(text, sizeof text, "%lld:%02lld", whole / 60, whole % 60);
    else
        std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
    return text;
}

double rate(const BatchCounts& counts, double seconds) {
    return seconds > 0 ? static_cast<double>(counts.ended()) / seconds : 0;
}

Json counts_json(const char* event, const BatchCounts& counts) {
    Json json = {
        {"event", event}, {"units", counts.units}, {"done", counts.done}, {"up_to_date", counts.up_to_date}};
    if (counts.would_run > 0) json["would_run"] = counts.would_run;
    json["failed"] = counts.failed;
    return json;
}

}  // namespace

std::string table_csv(const std::vector<TableRow>& rows) {
    Columns columns;
    std::vector<std::vector<std::string>> table;
    for (const TableRow& row : rows) {
        Json report = report_of(row);
        Json warnings = row.result.warnings;  // those of a row that is up to date are in its report
        if (report.is_object() && report.contains("warnings")) {
            warnings = report["warnings"];
            report.erase("warnings");
        }
        Values values = {{"name", row.name},
                         {"status", outcome_name(row.result.outcome)},
                         {"exit_code", std::to_string(row.result.exit_code)},
                         {"error", row.result.message}};
        flatten(warnings, "warnings", values);
        flatten(report, "", values);
        std::vector<std::string>& cells = table.emplace_back();
        for (const auto& [name, value] : values) {
            const std::size_t column = columns.at(name);
            if (cells.size() <= column) cells.resize(column + 1);
            cells[column] = value;
        }
    }
    std::string text = csv_line(columns.names());
    for (std::vector<std::string>& cells : table) {
        cells.resize(columns.names().size());
        text += csv_line(cells);
    }
    return text;
}

std::string table_json(const std::vector<TableRow>& rows) {
    // Written row by row, so that the reports of ten thousand units are not held as objects at the same time.
    std::string text = R"({"schema": 1, "version": ")" HEXRELIEF_VERSION R"(", "rows": [)";
    for (const TableRow& row : rows) {
        Json json = {{"name", row.name},
                     {"status", outcome_name(row.result.outcome)},
                     {"exit_code", row.result.exit_code},
                     {"error", row.result.message.empty() ? Json(nullptr) : Json(row.result.message)}};
        if (row.result.outcome == UnitOutcome::failed) json["warnings"] = row.result.warnings;
        json["report"] = report_of(row);
        text += (text.ends_with('[') ? "\n" : ",\n") + json_text(json);
    }
    return text + "\n]}\n";
}

void BatchCounts::add(UnitOutcome outcome) {
    if (outcome == UnitOutcome::done) ++done;
    if (outcome == UnitOutcome::up_to_date) ++up_to_date;
    if (outcome == UnitOutcome::would_run) ++would_run;
    if (outcome == UnitOutcome::failed) ++failed;
}

std::string progress_bar(const BatchCounts& counts, double seconds) {
    std::string bar(kBarWidth, '.');
    const std::size_t full = counts.units == 0 ? kBarWidth : kBarWidth * counts.ended() / counts.units;
    for (std::size_t i = 0; i < std::min(full, kBarWidth); ++i) bar[i] = '#';
    bar = "[" + bar + "] " + std::to_string(counts.ended()) + "/" + std::to_string(counts.units);
    if (counts.failed > 0) bar += ", " + std::to_string(counts.failed) + " failed";
    const double per_second = rate(counts, seconds);
    if (per_second <= 0) return bar;
    return bar + ", " + fixed(per_second, 1) + " a second, " +
           clock_text(static_cast<double>(counts.units - counts.ended()) / per_second) + " left";
}

std::string batch_summary(const BatchCounts& counts, double seconds) {
    std::string text = std::to_string(counts.units) + (counts.units == 1 ? " row in " : " rows in ") +
                       fixed(seconds, 2) + " s, " + fixed(rate(counts, seconds), 1) + " a second: ";
    if (counts.would_run > 0)
        text += std::to_string(counts.would_run) + " to do, ";
    else
        text += std::to_string(counts.done) + " done, ";
    return text + std::to_string(counts.up_to_date) + " up to date, " + std::to_string(counts.failed) +
           " failed\n";
}

std::string start_event(const BatchCounts& counts) {
    return event_text({{"event", "start"}, {"version", HEXRELIEF_VERSION}, {"units", counts.units}});
}

std::string unit_event(const BatchUnit& unit, const UnitResult& result, const BatchCounts& counts) {
    Json json = {{"event", "unit"},           {"name", unit.name},
                 {"place", unit.place},       {"status", outcome_name(result.outcome)},
                 {"seconds", result.seconds}, {"peak_bytes", result.peak_bytes}};
    if (!unit.rule.empty()) json["rule"] = unit.rule;
    if (result.outcome == UnitOutcome::failed) {
        json["exit_code"] = result.exit_code;
        json["error"] = result.message;
    } else if (!result.message.empty()) {
        json["reason"] = result.message;
    }
    if (!result.warnings.empty()) json["warnings"] = result.warnings;
    json["ended"] = counts.ended();
    json["units"] = counts.units;
    return event_text(json);
}

std::string end_event(const BatchCounts& counts, double seconds) {
    Json json = counts_json("end", counts);
    json["seconds"] = seconds;
    json["units_per_second"] = rate(counts, seconds);
    return event_text(json);
}

}  // namespace hexrelief::batch
