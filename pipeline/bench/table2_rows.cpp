#include "pipeline/bench/table2_rows.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hexrelief::bench::table2 {
namespace {

using Json = nlohmann::ordered_json;

std::string by(int a, int b) {
    return std::to_string(a) + "x" + std::to_string(b);
}

constexpr const char* kHeadings =
    "                                                                                             mesh, "
    "seconds    "
    " surface         %cost     max  weights %    "
    "inver-   angle deg     |     paper: s          %cost\n"
    "map      image      grid     cells    SSR CRR  iter.  method      backend    median   spread   median   "
    "  "
    "        "
    "dev. %    p5   p95    ted      p1  median |   GPU    CPU    GPU    CPU\n";

std::string paper_columns(double gpu_s, double cpu_s, double gpu_cost, double cpu_cost) {
    return format(" | %6.2f %6.2f  %5.2f  %5.2f\n", gpu_s, cpu_s, gpu_cost, cpu_cost);
}

Json paper_json(double gpu_s, double cpu_s, double gpu_cost, double cpu_cost) {
    Json json;
    json["gpu_seconds"] = gpu_s;
    json["cpu_seconds"] = cpu_s;
    json["gpu_percent_cost"] = gpu_cost;
    json["cpu_percent_cost"] = cpu_cost;
    return json;
}

Json times_json(const Times& times) {
    return {{"median", times.median()}, {"spread", times.most() - times.least()}, {"runs", times.runs}};
}

}  // namespace

std::string headings() {
    return kHeadings;
}

std::string row_text(const Row& row) {
    return format(
               "%-8s %-10s %-8s %-8s %3d %3d %6d  %-11s %-7s  %8.3f %8.3f %8.3f    %8.2f %7.1f %5.0f %5.0f "
               "%6lld "
               "%7.2f "
               "%7.2f",
               row.paper->name, by(row.width, row.height).c_str(), by(row.columns, row.rows).c_str(),
               by(row.cell_columns, row.cell_rows).c_str(), row.ssr, row.crr, row.iterations,
               row.method.c_str(), row.backend.c_str(), row.mesh.median(), row.mesh.most() - row.mesh.least(),
               row.surface.median(), row.quality.percent_cost, row.quality.max_deviation_percent,
               row.quality.percentile5_weight_percent, row.quality.percentile95_weight_percent,
               row.quality.inverted_triangles, row.quality.percentile1_angle_deg,
               row.quality.median_angle_deg) +
           paper_columns(row.paper->gpu_s, row.paper->cpu_s, row.paper->gpu_cost, row.paper->cpu_cost);
}

std::vector<Average> averages(const std::vector<Row>& rows, const std::string& set) {
    std::vector<Average> result;
    for (const Row& row : rows) {
        if (row.paper->set != set) continue;
        auto at = std::find_if(result.begin(), result.end(), [&](const Average& a) {
            return a.method == row.method && a.backend == row.backend;
        });
        if (at == result.end()) at = result.insert(at, Average{set, row.method, row.backend});
        ++at->maps;
        at->seconds += row.mesh.median();
        at->surface_s += row.surface.median();
        at->percent_cost += row.quality.percent_cost;
        at->inverted += row.quality.inverted_triangles;
        at->gpu_s += row.paper->gpu_s;
        at->cpu_s += row.paper->cpu_s;
        at->gpu_cost += row.paper->gpu_cost;
        at->cpu_cost += row.paper->cpu_cost;
    }
    for (Average& a : result)
        for (double* sum :
             {&a.seconds, &a.surface_s, &a.percent_cost, &a.gpu_s, &a.cpu_s, &a.gpu_cost, &a.cpu_cost})
            *sum /= a.maps;
    return result;
}

std::string average_text(const Average& a) {
    const std::string over = "mean of " + std::to_string(a.maps) + (a.maps == 1 ? " map" : " maps");
    return format("%-52s %-11s %-7s  %8.3f %8s %8.3f    %8.2f %7s %11s %6lld %7s %7s", over.c_str(),
                  a.method.c_str(), a.backend.c_str(), a.seconds, "", a.surface_s, a.percent_cost, "", "",
                  a.inverted, "", "") +
           paper_columns(a.gpu_s, a.cpu_s, a.gpu_cost, a.cpu_cost);
}

nlohmann::ordered_json row_json(const Row& row) {
    Json json;
    json["set"] = row.paper->set;
    json["map"] = row.paper->name;
    json["width"] = row.width;
    json["height"] = row.height;
    json["columns"] = row.columns;
    json["rows"] = row.rows;
    json["cell_columns"] = row.cell_columns;
    json["cell_rows"] = row.cell_rows;
    json["ssr"] = row.ssr;
    json["crr"] = row.crr;
    json["iterations"] = row.iterations;
    json["method"] = row.method;
    json["backend"] = row.backend;
    json["seconds"] = times_json(row.mesh);
    json["surface_seconds"] = times_json(row.surface);
    json["percent_cost"] = row.quality.percent_cost;
    json["max_deviation_percent"] = row.quality.max_deviation_percent;
    json["honeycomb_cells"] = row.quality.honeycomb_cells;
    json["inverted_triangles"] = row.quality.inverted_triangles;
    json["min_angle_deg"] = row.quality.min_angle_deg;
    json["percentile1_angle_deg"] = row.quality.percentile1_angle_deg;
    json["median_angle_deg"] = row.quality.median_angle_deg;
    json["weights_percent"] = {{"p5", row.quality.percentile5_weight_percent},
                               {"p50", row.quality.percentile50_weight_percent},
                               {"p95", row.quality.percentile95_weight_percent}};
    json["paper"] = paper_json(row.paper->gpu_s, row.paper->cpu_s, row.paper->gpu_cost, row.paper->cpu_cost);
    return json;
}

nlohmann::ordered_json average_json(const Average& a) {
    Json json;
    json["set"] = a.set;
    json["method"] = a.method;
    json["backend"] = a.backend;
    json["maps"] = a.maps;
    json["seconds"] = a.seconds;
    json["surface_seconds"] = a.surface_s;
    json["percent_cost"] = a.percent_cost;
    json["inverted_triangles"] = a.inverted;
    json["paper"] = paper_json(a.gpu_s, a.cpu_s, a.gpu_cost, a.cpu_cost);
    return json;
}

}  // namespace hexrelief::bench::table2
