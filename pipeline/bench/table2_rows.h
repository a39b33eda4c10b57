// The rows of `hexrelief bench table2`, their means, and both as text and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/bench/bench_rows.h"
#include "pipeline/bench/table2_paper.h"

namespace hexrelief::bench::table2 {

struct Row {
    const PaperMap* paper = nullptr;
    std::string method, backend;
    int width = 0, height = 0, columns = 0, rows = 0, cell_columns = 0, cell_rows = 0, ssr = 0, crr = 0;
    int iterations = 0;
    Times mesh, surface;  // of the two stages; the surface stage runs on the CPU for every backend
    quality::MeshQuality quality;
};

// Means over the rows of one set, method and backend, and the paper's over the same maps.
struct Average {
    std::string set, method, backend;
    int maps = 0;
    double seconds = 0, surface_s = 0, percent_cost = 0;
    long long inverted = 0;
    double gpu_s = 0, cpu_s = 0, gpu_cost = 0, cpu_cost = 0;
};

// Returns the means for each method and backend in the set's rows.
std::vector<Average> averages(const std::vector<Row>& rows, const std::string& set);

// Returns the two lines above the rows.
std::string headings();
// Each returns one line, with its line feed.
std::string row_text(const Row& row);
std::string average_text(const Average& average);

nlohmann::ordered_json row_json(const Row& row);
nlohmann::ordered_json average_json(const Average& average);

}  // namespace hexrelief::bench::table2
