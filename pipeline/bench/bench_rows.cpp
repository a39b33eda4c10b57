#include "pipeline/bench/bench_rows.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "exporters/core/file_transaction.h"

namespace hexrelief::bench {

double Times::median() const {
    if (runs.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::vector<double> sorted = runs;
    std::sort(sorted.begin(), sorted.end());
    return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
}

double Times::least() const {
    return runs.empty() ? median() : *std::min_element(runs.begin(), runs.end());
}

double Times::most() const {
    return runs.empty() ? median() : *std::max_element(runs.begin(), runs.end());
}

std::string json_text(const nlohmann::ordered_json& json, int indent) {
    return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void write_json(const std::filesystem::path& path, const std::string& text) {
    if (path.empty()) return;
    exporters::FileTransaction files;
    files.write(path, text);
    files.commit();
}

void write_json(const std::filesystem::path& path, const nlohmann::ordered_json& json) {
    write_json(path, json_text(json, 2) + "\n");
}

}  // namespace hexrelief::bench
