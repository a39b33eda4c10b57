// The rows of `hexrelief bench match`, their means, and both as text and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "pipeline/bench/bench_rows.h"
#include "pipeline/evaluation/evaluate.h"

namespace hexrelief::bench {

// Returns the JSON that `hexrelief evaluate --json` prints.
nlohmann::ordered_json evaluation_json(const evaluation::DisparityEvaluation& evaluation);

namespace match {

struct Row {
    std::string scene, size, method, backend;
    int width = 0, height = 0;
    int disparities = 0;   // of the range that was searched
    Times disparity = {};  // of the whole stage, the choice of the range included
    evaluation::DisparityEvaluation evaluation = {};
    double filled_percent = 0;  // share of all pixels that are known without a match
};

// Means over the rows of one size, method and backend.
struct Average {
    std::string size, method, backend;
    int scenes = 0;
    double seconds = 0;
    double bad1 = 0, bad2 = 0, bad1_nonoccluded = 0, bad2_nonoccluded = 0;  // percent
    double edge = 0;                                                        // percent: wrong or unknown
    double coverage = 0;                                                    // percent
    double average_error_px = 0, roughness_px = 0;
};
// Returns the means for each size, method and backend, in the order of the rows.
std::vector<Average> averages(const std::vector<Row>& rows);

// Returns the two lines above the rows.
std::string headings();
// Each returns one line, with its line feed.
std::string row_text(const Row& row);
std::string average_text(const Average& average);

nlohmann::ordered_json row_json(const Row& row);
nlohmann::ordered_json average_json(const Average& average);

}  // namespace match
}  // namespace hexrelief::bench
