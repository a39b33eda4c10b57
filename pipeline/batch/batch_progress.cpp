#include "pipeline/batch/batch_progress.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "pipeline/data/number_text.h"
#include "pipeline/job/log/run_log.h"

namespace hexrelief::batch {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kBarWidth = 20;

std::string event_text(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
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
    Json json = {{"event", "start"}, {"version", HEXRELIEF_VERSION}, {"units", counts.units}};
    return event_text(json);
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
