#include "pipeline/evaluation/evaluate.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/data/error.h"
#include "pipeline/evaluation/evaluate_parts.h"

namespace hexrelief::evaluation {
namespace {

// Returns the distance between windows: larger pictures have larger discontinuities, and
// need no denser windows.
int roughness_step_px(double discontinuity_px) {
    return static_cast<int>(std::clamp(std::round(4 * discontinuity_px), 1.0, 64.0));
}

void check_size(const DisparityMap& map, const std::string& name, const DisparityMap& truth) {
    if (map.width == truth.width && map.height == truth.height) return;
    const auto size = [](const DisparityMap& of) {
        return std::to_string(of.width) + "x" + std::to_string(of.height);
    };
    throw Error(ErrorKind::input, name + " is " + size(map) + ", its ground truth " + size(truth) +
                                      "; give two maps of one size");
}

double percent(long long part, long long whole) {
    return whole > 0 ? 100.0 * part / whole : 0;
}

void count_errors(DisparityEvaluation& result, const DisparityMap& map, const DisparityMap& truth,
                  const DisparityMap* right_truth) {
    const std::vector<std::uint8_t> nonoccluded = find_nonoccluded(truth, right_truth);
    long long known = 0, bad[4] = {}, bad_nonoccluded[4] = {};
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < truth.values.size(); ++i) {
        if (!is_given(truth.values[i])) continue;
        ++result.truth_pixels;
        result.nonoccluded_pixels += nonoccluded[i];
        double error = std::numeric_limits<double>::infinity();
        if (is_given(map.values[i])) {
            error = std::fabs(static_cast<double>(map.values[i]) - truth.values[i]);
            ++known;
            sum += error;
            squares += error * error;
        }
        for (int k = 0; k < 4; ++k) {
            bad[k] += error > kBadThresholds_px[k];
            bad_nonoccluded[k] += nonoccluded[i] && error > kBadThresholds_px[k];
        }
    }
    for (int k = 0; k < 4; ++k) {
        result.bad_percent[k] = percent(bad[k], result.truth_pixels);
        result.bad_nonoccluded_percent[k] = percent(bad_nonoccluded[k], result.nonoccluded_pixels);
        result.bad_known_percent[k] = percent(bad[k] - (result.truth_pixels - known), known);
    }
    result.coverage_percent = percent(known, result.truth_pixels);
    if (known > 0) {
        result.average_error_px = sum / known;
        result.rms_error_px = std::sqrt(squares / known);
    }
}

}  // namespace

DisparityEvaluation evaluate_disparity(const DisparityMap& map, const DisparityMap& truth,
                                       const EvaluationConfig& config) {
    check_size(map, "the disparity map", truth);
    if (config.right_truth) check_size(*config.right_truth, "the right view's ground truth", truth);
    if (!(config.discontinuity_px > 0))
        throw Error(ErrorKind::usage, "the least discontinuity must be above 0 px");
    DisparityEvaluation result;
    count_errors(result, map, truth, config.right_truth);
    if (result.truth_pixels == 0) {
        throw Error(ErrorKind::input,
                    "the ground truth has no known pixel; check its scale and unknown value");
    }
    const EdgeCounts edges = count_edges(map, truth, static_cast<float>(config.discontinuity_px));
    result.edge_pixels = edges.pixels;
    result.edge_wrong_percent = percent(edges.wrong, edges.pixels);
    result.edge_unknown_percent = percent(edges.unknown, edges.pixels);
    const Roughness roughness = measure_roughness(map, truth, roughness_step_px(config.discontinuity_px));
    result.roughness_px = roughness.rms_px;
    result.roughness_windows = roughness.windows;
    return result;
}

nlohmann::ordered_json evaluation_json(const DisparityEvaluation& e) {
    nlohmann::ordered_json json;
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

}  // namespace hexrelief::evaluation
