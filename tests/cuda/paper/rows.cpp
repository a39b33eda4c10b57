#include "tests/cuda/paper/rows.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace hexrelief::paper {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double value, int digits) {
    const double scale = std::pow(10.0, digits);
    return std::round(value * scale) / scale;
}

Json times_json(const Times& times) {
    return {{"median", rounded(times.median() * 1e3, 4)},
            {"least", rounded(times.least() * 1e3, 4)},
            {"most", rounded(times.most() * 1e3, 4)}};
}

void append_baseline(const Config& config, Json& json) {
    json["kernels"] = kKernelsNames[static_cast<int>(config.kernels)];
    json["memory"] = kMemoryNames[static_cast<int>(config.memory)];
    if (config.kernels == Kernels::single)
        json["block"] = {{"single", config.block_single}};
    else
        json["block"] = {{"extraction", config.block_extraction},
                         {"search", config.block_search},
                         {"learning", config.block_learning}};
}

}  // namespace

nlohmann::ordered_json row_json(const Row& row) {
    Json json = {{"experiment", row.experiment}, {"map", row.map},         {"width", row.width},
                 {"height", row.height},         {"columns", row.columns}, {"rows", row.rows},
                 {"solver", row.solver}};
    if (row.baseline) {
        append_baseline(*row.baseline, json);
        json["escaped"] = row.escaped;
    }
    json["co"] = row.co;
    json["ssr"] = row.ssr;
    json["crr"] = row.crr;
    json["sigma_init"] = row.sigma_init;
    json["iterations"] = row.iterations;
    json["runs"] = row.stage_s.runs.size();
    if (!row.som_s.empty()) json["som_ms"] = times_json(row.som_s);
    json["stage_ms"] = times_json(row.stage_s);
    for (const auto& [kernel, times] : row.kernels)
        json["kernels_ms"][kernel] = rounded(times.median() * 1e3, 4);
    if (std::isfinite(row.percent_cost)) json["percent_cost"] = rounded(row.percent_cost, 3);
    json["inverted_triangles"] = row.inverted;
    if (row.device_bytes > 0) json["device_bytes"] = row.device_bytes;
    return json;
}

}  // namespace hexrelief::paper
