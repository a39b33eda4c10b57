#include "pipeline/evaluation/evaluation_json.h"

#include <nlohmann/json.hpp>

namespace hexrelief::evaluation {

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
