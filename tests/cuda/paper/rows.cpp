#include "tests/cuda/paper/rows.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace hexrelief::paper {
namespace {

using Json = nlohmann::ordered_json;

// Returns milliseconds with as many digits as are meaningful; "-" for none.
std::string ms(double seconds) {
    if (!std::isfinite(seconds)) return "-";
    const double value = seconds * 1e3;
    return format(value < 100 ? "%.3f" : "%.1f", value);
}

std::string ssr_text(int ssr) {
    return ssr == 0 ? "inf" : std::to_string(ssr);
}

std::string blocks_text(const Row& row) {
    if (row.kernels == "single") return std::to_string(row.block_single);
    if (row.kernels.empty()) return "-";
    return std::to_string(row.block_extraction) + "/" + std::to_string(row.block_search) + "/" +
           std::to_string(row.block_learning);
}

std::string kernels_text(const Row& row) {
    if (!row.single_s.empty()) return ms(row.single_s.median());
    if (row.extraction_s.empty()) return "-";
    return ms(row.extraction_s.median()) + "/" + ms(row.search_s.median()) + "/" +
           ms(row.learning_s.median());
}

double rounded(double value, int digits) {
    const double scale = std::pow(10.0, digits);
    return std::round(value * scale) / scale;
}

Json times_json(const Times& times) {
    return {{"median", rounded(times.median() * 1e3, 4)},
            {"least", rounded(times.least() * 1e3, 4)},
            {"most", rounded(times.most() * 1e3, 4)}};
}

}  // namespace

std::string headings() {
    return format(
               "%-10s %-13s %-11s %-9s %-8s %-9s %-11s %3s %3s %3s %5s %5s  %9s %19s %9s %7s  %-21s %7s %8s "
               "%8s %8s\n",
               "", "", "", "", "", "", "", "", "", "", "", "", "SOM, ms", "", "stage, ms", "SOM,",
               "its kernels, ms", "", "", "", "") +
           format(
               "%-10s %-13s %-11s %-9s %-8s %-9s %-11s %3s %3s %3s %5s %5s  %9s %19s %9s %7s  %-21s %7s %8s "
               "%8s %8s\n",
               "experiment", "map", "image", "solver", "kernels", "memory", "block", "co", "ssr", "crr",
               "sigma", "iter.", "median", "least - most", "median", "ns/px", "(one, or E/S/L)", "%cost",
               "inverted", "escaped", "MiB");
}

std::string row_text(const Row& row) {
    const std::string image = std::to_string(row.width) + "x" + std::to_string(row.height);
    const std::string range = row.som_s.empty() ? "-" : ms(row.som_s.least()) + " - " + ms(row.som_s.most());
    return format(
        "%-10s %-13s %-11s %-9s %-8s %-9s %-11s %3d %3s %3d %5g %5d  %9s %19s %9s %7s  %-21s %7s %8lld "
        "%8lld "
        "%8.1f\n",
        row.experiment.c_str(), row.map.c_str(), image.c_str(), row.solver.c_str(),
        row.kernels.empty() ? "-" : row.kernels.c_str(), row.memory.empty() ? "-" : row.memory.c_str(),
        blocks_text(row).c_str(), row.co, ssr_text(row.ssr).c_str(), row.crr, row.sigma_init, row.iterations,
        ms(row.som_s.median()).c_str(), range.c_str(), ms(row.stage_s.median()).c_str(),
        row.som_s.empty() ? "-" : format("%.2f", row.nanoseconds_per_pixel()).c_str(),
        kernels_text(row).c_str(),
        std::isfinite(row.percent_cost) ? format("%.2f", row.percent_cost).c_str() : "-", row.inverted,
        row.escaped, static_cast<double>(row.device_bytes) / (1 << 20));
}

nlohmann::ordered_json row_json(const Row& row) {
    Json json;
    json["experiment"] = row.experiment;
    json["map"] = row.map;
    json["width"] = row.width;
    json["height"] = row.height;
    json["columns"] = row.columns;
    json["rows"] = row.rows;
    json["solver"] = row.solver;
    if (!row.kernels.empty()) {
        json["kernels"] = row.kernels;
        json["memory"] = row.memory;
        if (row.kernels == "single")
            json["block"] = {{"single", row.block_single}};
        else
            json["block"] = {{"extraction", row.block_extraction},
                             {"search", row.block_search},
                             {"learning", row.block_learning}};
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
    if (!row.single_s.empty()) json["kernels_ms"] = {{"single", rounded(row.single_s.median() * 1e3, 4)}};
    if (!row.extraction_s.empty())
        json["kernels_ms"] = {{"extraction", rounded(row.extraction_s.median() * 1e3, 4)},
                              {"search", rounded(row.search_s.median() * 1e3, 4)},
                              {"learning", rounded(row.learning_s.median() * 1e3, 4)}};
    if (std::isfinite(row.percent_cost)) json["percent_cost"] = rounded(row.percent_cost, 3);
    json["inverted_triangles"] = row.inverted;
    if (row.device_bytes > 0) json["device_bytes"] = row.device_bytes;
    return json;
}

}  // namespace hexrelief::paper
