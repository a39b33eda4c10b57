#include "pipeline/job/report.h"

#include <sys/resource.h>
#include <utility>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/config/document.h"

namespace hexrelief::job {
namespace {

using Json = nlohmann::ordered_json;

Json finite(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json calibration_json(const Calibration& camera) {
    Json json;
    json["focal_px"] = camera.focal_px;
    json["cx"] = camera.cx;
    json["cy"] = camera.cy;
    json["baseline_m"] = camera.baseline_m;
    json["doffs_px"] = camera.doffs_px;
    json["metric"] = camera.metric;
    return json;
}

Json filling_json(const std::optional<FillingReport>& filling) {
    if (!filling) return nullptr;
    Json json;
    json["measured_share"] = filling->measured_share;
    json["filled_share"] = filling->filled_share;
    return json;
}

Json input_json(const RunReport& report) {
    Json json;
    json["paths"] = Json::object();
    json["width"] = report.width;
    json["height"] = report.height;
    json["sha256"] = Json::object();
    for (const InputFile& file : report.inputs) {
        json["paths"][file.role] = file.path;
        json["sha256"][file.role] = file.sha256;
    }
    json["calibration"] = calibration_json(report.calibration);
    json["believed"]["focal"] = report.believed.focal_from;
    json["believed"]["baseline"] = report.believed.baseline_from;
    json["believed"]["depth"] = report.believed.depth.empty() ? Json(nullptr) : Json(report.believed.depth);
    json["known_share"] = report.shares.known();
    json["densified"] = filling_json(report.filling);
    json["quantum_px"] = report.quantum_px > 0 ? Json(report.quantum_px) : Json(nullptr);
    return json;
}

// Meshed or not, and why not.
Json picture_json(const PictureShares& shares) {
    Json json;
    json["meshed_share"] = shares.meshed;
    json["background_share"] = shares.background;
    json["unknown_share"] = shares.unknown;
    json["occluded_share"] = shares.occluded;
    return json;
}

Json matching_json(const std::optional<MatchingReport>& matching) {
    if (!matching) return nullptr;
    Json json;
    json["method"] = matching->config.method == stages::DisparityMethod::sgm ? "sgm" : "sgbm";
    json["min_disparity_px"] = matching->config.min_disparity_px;
    json["num_disparities_px"] = matching->config.num_disparities_px;
    json["matched_share"] = matching->matched_share;
    json["filled_share"] = matching->filled_share;
    return json;
}

double share_of(PixelOrigin origin, const DisparityMap& map) {
    return static_cast<double>(std::count(map.origins.begin(), map.origins.end(), origin)) /
           static_cast<double>(map.origins.size());
}

// Honeycomb weights in percent of their mean.
Json weights_json(const quality::MeshQuality& quality) {
    Json json;
    json["p5"] = finite(quality.percentile5_weight_percent);
    json["p50"] = finite(quality.percentile50_weight_percent);
    json["p95"] = finite(quality.percentile95_weight_percent);
    return json;
}

// Smallest angles of the triangles.
Json angles_json(const quality::MeshQuality& quality) {
    Json json;
    json["min"] = finite(quality.min_angle_deg);
    json["p1"] = finite(quality.percentile1_angle_deg);
    json["median"] = finite(quality.median_angle_deg);
    return json;
}

Json mesh_json(const RunReport& report) {
    Json json;
    json["columns"] = report.columns;
    json["rows"] = report.rows;
    json["vertices"] = static_cast<long long>(report.columns) * report.rows;
    json["triangles"] = report.lattice_triangles;
    json["iterations"] = report.iterations;
    json["device_seconds"] = report.device_training_s;
    json["device_balance_seconds"] = report.device_balance_s;
    json["device_surface_seconds"] = report.device_surface_s;
    json["device_sheet_seconds"] = report.device_surface_s;  // its former name, for those who still read it
    json["device_bytes"] = report.device_bytes;
    json["percent_cost"] = finite(report.quality.percent_cost);
    json["max_deviation_percent"] = finite(report.quality.max_deviation_percent);
    json["inverted_triangles"] = report.quality.inverted_triangles;
    json["min_angle_deg"] = finite(report.quality.min_angle_deg);
    json["honeycomb_cells"] = report.quality.honeycomb_cells;
    json["weights_percent"] = weights_json(report.quality);
    json["angles_deg"] = angles_json(report.quality);
    return json;
}

Json surface_json(const RunReport& report) {
    Json json;
    json["vertices"] = report.vertices;
    json["triangles"] = report.triangles;
    json["components"] = report.components;
    json["boundary_loops"] = report.boundary_loops;
    json["bounds"] = {{report.bounds.low.x, report.bounds.low.y, report.bounds.low.z},
                      {report.bounds.high.x, report.bounds.high.y, report.bounds.high.z}};
    json["metric"] = report.calibration.metric;
    const stages::SurfaceQuality& quality = report.surface_quality;
    json["rmse_near_px"] = quality.rmse_near_px;
    json["duo_rmse_near_px"] = quality.duo_rmse_near_px;
    json["flat_rmse_px"] = quality.flat_rmse_px;
    json["sheet_share"] = quality.sheet_share;
    json["coverage"] = quality.coverage;
    json["slack_coverage"] = quality.slack_coverage;
    return json;
}

Json budget_json(const budget::BudgetResult& budget) {
    if (budget.kind.empty()) return nullptr;
    Json json;
    json["kind"] = budget.kind;
    json["limit"] = budget.limit;
    json["reached"] = budget.reached;
    json["spacing_px"] = budget.spacing_px;
    json["tolerance_px"] = budget.tolerance_px;
    json["solves"] = budget.solves;
    json["texture_quality"] = budget.texture ? Json(budget.texture->quality) : Json(nullptr);
    json["texture_max_px"] = budget.texture ? Json(budget.texture->max_px) : Json(nullptr);
    return json;
}

// Paths need not be UTF-8: what is not becomes U+FFFD rather than an exception.
std::string dump(const Json& json, int indent) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::size_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

}  // namespace

PictureShares shares_of(const LeftView& view, const SurfaceResult& result) {
    return share_picture(view.meshed, view.density.background_px, result.surface.mesh);
}

RunReport assemble_report(const RunResults& results, const RunContext& run) {
    const auto& [backend_reason, input, disparity, view, result, measures, coarser, outputs, shares] =
        results;
    const mesher::MeshResult& lattice = result.lattice;
    RunReport report;
    report.backend = run.backend.name;
    report.backend_reason = backend_reason;
    report.device = run.backend.device;
    report.threads = run.threads;
    report.config = result.config;
    report.inputs = input.files;
    report.believed = input.believed;
    report.width = view.disparity.width;
    report.height = view.disparity.height;
    report.calibration = view.calibration;
    report.quantum_px = disparity.quantum_px;
    if (const DisparityMap& map = disparity.map; !map.origins.empty()) {
        const double measured = share_of(PixelOrigin::matched, map),
                     filled = share_of(PixelOrigin::filled, map);
        if (disparity.is_matched)
            report.matching = {disparity.config, measured, filled};
        else
            report.filling = {measured, filled};
    }
    report.stage_seconds = run.log.stage_seconds();
    report.columns = lattice.mesh.columns;
    report.rows = lattice.mesh.rows;
    report.lattice_triangles = lattice.mesh.triangle_count();
    report.iterations = lattice.iterations;
    report.device_training_s = lattice.device_training_s;
    report.device_balance_s = lattice.device_balance_s;
    report.device_surface_s = result.surface.device_s;
    report.device_bytes = lattice.device_bytes;
    report.quality = result.quality;
    report.vertices = result.surface.mesh.positions.size();
    report.triangles = result.surface.mesh.triangles.size();
    report.components = measures.topology.components;
    report.boundary_loops = measures.topology.boundary_loops;
    for (const auto& [spacing_px, mesh] : coarser)
        report.levels.push_back({spacing_px, mesh.positions.size(), mesh.triangles.size()});
    report.bounds = result.surface.bounds;
    report.surface_quality = measures.quality;
    report.budget = result.budget;
    report.outputs = outputs;
    report.warnings = run.log.warnings();
    report.shares = shares;
    if (!input.believed.depth.empty())  // no right camera
        report.shares.unknown += std::exchange(report.shares.occluded, 0);
    report.seconds = run.log.seconds();
    report.peak_bytes = peak_bytes();
    return report;
}

std::string report_json(const RunReport& report) {
    Json json;
    json["schema"] = 1;
    json["hexrelief"]["version"] = HEXRELIEF_VERSION;
    if (!report.stamp.empty()) json["stamp"] = report.stamp;
    json["backend"] = report.backend;
    json["backend_reason"] = report.backend_reason;
    json["device"] = report.device;
    json["threads"] = report.threads;
    json["seed"] = report.config.mesh.seed;
    json["config"] = config::config_json(report.config);
    json["input"] = input_json(report);
    json["foreground_share"] = report.shares.foreground;
    json["picture"] = picture_json(report.shares);
    json["depth_range"] = {report.nearest(), report.farthest()};
    json["disparity"] = matching_json(report.matching);
    json["stages"] = Json::array();
    for (const auto& [name, seconds] : report.stage_seconds)
        json["stages"].push_back({{"name", name}, {"seconds", seconds}});
    json["mesh"] = mesh_json(report);
    json["surface"] = surface_json(report);
    if (!report.levels.empty()) {
        json["levels"] = Json::array();
        for (const LevelReport& level : report.levels)
            json["levels"].push_back({{"spacing_px", level.spacing_px},
                                      {"vertices", level.vertices},
                                      {"triangles", level.triangles}});
    }
    json["budget"] = budget_json(report.budget);
    json["outputs"] = Json::array();
    for (const OutputFile& file : report.outputs)
        json["outputs"].push_back(
            {{"path", file.path}, {"format", file.format}, {"bytes", file.bytes}, {"sha256", file.sha256}});
    json["warnings"] = report.warnings;
    json["seconds"] = report.seconds;
    json["peak_bytes"] = report.peak_bytes;
    return dump(json, 2) + "\n";
}

std::string extras_json(const LeftView& view, const SurfaceResult& result) {
    Json parameters = config::config_json(result.config);
    parameters.erase("run");
    parameters.erase("budget");  // what it led to is in the other keys
    Json& input = parameters["input"];
    input["calibration"].erase("file");
    if (input["disparity"]["key"] == "") input["disparity"].erase("key");
    // Where depths were not read otherwise than by default, files stay what they were before there were any.
    const Json defaults = config::config_json({})["input"];
    for (const char* const section : {"depth", "mask", "confidence"})
        if (input[section] == defaults[section]) input.erase(section);
    Json json;
    json["hexrelief"]["version"] = HEXRELIEF_VERSION;
    json["hexrelief"]["config"] = std::move(parameters);
    json["hexrelief"]["calibration"] = calibration_json(view.calibration);
    json["hexrelief"]["image"] = {{"width", view.disparity.width}, {"height", view.disparity.height}};
    json["hexrelief"]["percent_cost"] = finite(result.quality.percent_cost);
    return dump(json, -1);
}

}  // namespace hexrelief::job
