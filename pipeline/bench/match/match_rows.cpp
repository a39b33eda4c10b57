#include "pipeline/bench/match/match_rows.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hexrelief::bench {

using Json = nlohmann::ordered_json;

nlohmann::ordered_json evaluation_json(const evaluation::DisparityEvaluation& e) {
    Json json;
    json["bad_0.5_percent"] = e.bad_percent[0];
    json["bad_1_percent"] = e.bad_percent[1];
    json["bad_2_percent"] = e.bad_percent[2];
    json["bad_4_percent"] = e.bad_percent[3];
    json["average_error_px"] = e.average_error_px;
    json["rms_error_px"] = e.rms_error_px;
    json["coverage_percent"] = e.coverage_percent;
    json["truth_pixels"] = e.truth_pixels;
    json["bad_1_nonoccluded_percent"] = e.bad_nonoccluded_percent[1];
    json["bad_2_nonoccluded_percent"] = e.bad_nonoccluded_percent[2];
    json["bad_2_known_percent"] = e.bad_known_percent[2];
    json["nonoccluded_pixels"] = e.nonoccluded_pixels;
    json["edge_wrong_percent"] = e.edge_wrong_percent;
    json["edge_unknown_percent"] = e.edge_unknown_percent;
    json["edge_pixels"] = e.edge_pixels;
    json["roughness_px"] = e.roughness_px;
    json["roughness_windows"] = e.roughness_windows;
    return json;
}

namespace match {
namespace {

// Returns a row as the mean of itself, because both have the same columns.
Average of_row(const Row& row) {
    const evaluation::DisparityEvaluation& e = row.evaluation;
    return {row.size,
            row.method,
            row.backend,
            1,
            row.disparity.median(),
            e.bad_percent[1],
            e.bad_percent[2],
            e.bad_nonoccluded_percent[1],
            e.bad_nonoccluded_percent[2],
            e.edge_wrong_percent + e.edge_unknown_percent,
            e.coverage_percent,
            e.average_error_px,
            e.roughness_px};
}

constexpr double Average::*kFigures[] = {
    &Average::seconds,          &Average::bad1, &Average::bad2,     &Average::bad1_nonoccluded,
    &Average::bad2_nonoccluded, &Average::edge, &Average::coverage, &Average::average_error_px,
    &Average::roughness_px};

std::string columns_text(const std::string& over, const Average& a) {
    return format("%-36s %-12s %-5s %8.4f  %7.3f %7.3f %7.3f %7.3f %7.3f %8.3f %8.4f %8.4f\n", over.c_str(),
                  a.method.c_str(), a.backend.c_str(), a.seconds, a.bad1, a.bad2, a.bad1_nonoccluded,
                  a.bad2_nonoccluded, a.edge, a.coverage, a.average_error_px, a.roughness_px);
}

}  // namespace

std::vector<Average> averages(const std::vector<Row>& rows) {
    std::vector<Average> result;
    for (const Row& row : rows) {
        const Average one = of_row(row);
        auto at = std::find_if(result.begin(), result.end(), [&](const Average& a) {
            return a.size == one.size && a.method == one.method && a.backend == one.backend;
        });
        if (at == result.end()) {
            result.push_back(one);
            continue;
        }
        ++at->scenes;
        for (const auto figure : kFigures) *at.*figure += one.*figure;
    }
    for (Average& a : result)
        for (const auto figure : kFigures) a.*figure /= a.scenes;
    return result;
}

std::string headings() {
    return format("%-36s %-12s %-5s %8s  %7s %7s %7s %7s %7s %8s %8s %8s\n", "", "", "", "", "", "", "bad-1",
                  "bad-2", "edge", "cover-", "average", "rough-") +
           format("%-36s %-12s %-5s %8s  %7s %7s %7s %7s %7s %8s %8s %8s\n", "scene, size, disparities",
                  "method", "on", "s", "bad-1 %", "bad-2 %", "nonocc.", "nonocc.", "%", "age %", "px",
                  "ness px");
}

std::string row_text(const Row& row) {
    return columns_text(format("%-20s %dx%dx%d", row.scene.c_str(), row.width, row.height, row.disparities),
                        of_row(row));
}

std::string average_text(const Average& a) {
    return columns_text(
        format("mean of %d %s %s", a.scenes, a.size.c_str(), a.scenes == 1 ? "scene" : "scenes"), a);
}

nlohmann::ordered_json row_json(const Row& row) {
    Json json;
    json["scene"] = row.scene;
    json["size"] = row.size;
    json["width"] = row.width;
    json["height"] = row.height;
    json["disparities"] = row.disparities;
    json["method"] = row.method;
    json["backend"] = row.backend;
    json["seconds"] = {{"median", row.disparity.median()},
                       {"spread", row.disparity.most() - row.disparity.least()},
                       {"runs", row.disparity.runs}};
    json["filled_percent"] = row.filled_percent;
    json.update(evaluation_json(row.evaluation));
    return json;
}

nlohmann::ordered_json average_json(const Average& a) {
    Json json;
    json["size"] = a.size;
    json["method"] = a.method;
    json["backend"] = a.backend;
    json["scenes"] = a.scenes;
    json["seconds"] = a.seconds;
    json["bad_1_percent"] = a.bad1;
    json["bad_2_percent"] = a.bad2;
    json["bad_1_nonoccluded_percent"] = a.bad1_nonoccluded;
    json["bad_2_nonoccluded_percent"] = a.bad2_nonoccluded;
    json["edge_percent"] = a.edge;
    json["coverage_percent"] = a.coverage;
    json["average_error_px"] = a.average_error_px;
    json["roughness_px"] = a.roughness_px;
    return json;
}

}  // namespace match
}  // namespace hexrelief::bench
