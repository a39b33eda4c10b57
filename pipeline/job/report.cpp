#include "pipeline/job/report.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/config/document.h"
#include "pipeline/config/fields.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::job {
namespace {

using Json = nlohmann::ordered_json;

Json finite(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json filling_json(const DisparityResult& disparity) {
    const std::optional<OriginShares> shares = origin_shares(disparity.map);
    if (disparity.matched || !shares) return nullptr;
    return {{"measured_share", shares->measured}, {"filled_share", shares->filled}};
}

// Offsets of the rows of points that both pictures show, px of pictures of 1280 px.
Json rows_json(const alignment::RowFigures& rows) {
    return {{"median_px", rows.median_px},
            {"p90_px", rows.percentile90_px},
            {"beyond_1px_share", rows.beyond_share}};
}

Json alignment_json(const RunInput& input) {
    if (!input.pair() || !input.pair()->alignment) return nullptr;
    const alignment::Alignment& found = *input.pair()->alignment;
    const alignment::Estimate& estimate = found.estimate;
    Json json = {{"aligned", found.verdict == alignment::Verdict::aligned},
                 {"points", found.matches},
                 {"agreeing", estimate.agreeing.size()}};
    if (found.verdict == alignment::Verdict::unclear) return json;
    json["rows_before"] = rows_json(estimate.before);
    json["rows_after"] = rows_json(estimate.after);
    json["rows_held_out"] = rows_json(estimate.held_out);
    if (found.verdict != alignment::Verdict::aligned) return json;
    const alignment::Angles angles = alignment::angles_of(estimate.fit.parameters);
    json["angles_deg"] = {{"pitch", angles.pitch},
                          {"yaw", angles.yaw},
                          {"roll", angles.roll},
                          {"common_yaw", angles.common_yaw},
                          {"common_roll", angles.common_roll}};
    json["focal_ratio"] = alignment::factor_of(estimate.fit.parameters[alignment::kFocalRatio]);
    json["radial"] = estimate.fit.parameters[alignment::kRadial];
    json["focal_determined"] = found.is_focal_determined();
    json["infinity_known"] = found.disparities.is_infinity_known;
    json["exchanged"] = estimate.is_exchanged;
    json["quarter_turned"] = estimate.is_quarter_turned;
    return json;
}

Json input_json(const RunReport& report) {
    const RunInput& input = report.relief->input;
    const DisparityResult& disparity = report.relief->disparity;
    Json json = {{"paths", Json::object()},
                 {"width", disparity.map.width},
                 {"height", disparity.map.height},
                 {"reduced_by", input.reduced_by()},
                 {"sha256", Json::object()}};
    for (const InputFile& file : input.files) {
        json["paths"][file.role] = file.path;
        json["sha256"][file.role] = file.sha256;
    }
    json["calibration"] = calibration_json(report.relief->pair_camera);
    json["believed"]["focal"] = input.focal_from;
    json["believed"]["baseline"] = input.baseline_from;
    for (const bool is_depth : {true, false}) {
        const bool is_it = input.map() && input.map()->is_depth == is_depth && !input.map()->read_as.empty();
        json["believed"][is_depth ? "depth" : "disparity"] =
            is_it ? Json(input.map()->read_as) : Json(nullptr);
    }
    json["alignment"] = alignment_json(input);
    json["known_share"] = report.shares.known();
    json["densified"] = filling_json(disparity);
    json["quantum_px"] = disparity.quantum_px > 0 ? Json(disparity.quantum_px) : Json(nullptr);
    return json;
}

// Shares of meshed pixels, and of the others by reason.
Json picture_json(const PictureShares& shares) {
    return {{"meshed_share", shares.meshed},
            {"background_share", shares.background},
            {"unknown_share", shares.unknown},
            {"occluded_share", shares.occluded}};
}

Json backdrop_json(const Relief& relief) {
    const std::optional<stages::Backdrop>& backdrop = relief.disparity.backdrop;
    if (!backdrop) return nullptr;
    return {{"depth", relief.depth_of_backdrop()}, {"moved_share", backdrop->moved_share}};
}

Json matching_json(const Relief& relief) {
    const DisparityResult& disparity = relief.disparity;
    const std::optional<OriginShares> shares = origin_shares(disparity.map);
    if (!disparity.matched || !shares) return nullptr;
    Json json;
    const auto method = static_cast<std::size_t>(disparity.matched->method);
    json["method"] = config::find_field("disparity.method")->choices.at(method);
    json["min_disparity_px"] = disparity.matched->min_disparity_px;
    json["num_disparities_px"] = disparity.matched->num_disparities_px;
    json["matched_share"] = shares->measured;
    json["filled_share"] = shares->filled;
    json["support"] = disparity.support;
    json["support_word"] = relief.support();
    json["noise_px"] = disparity.noise.noise_px > 0 ? Json(disparity.noise.noise_px) : Json(nullptr);
    json["backdrop"] = backdrop_json(relief);
    return json;
}

double share_of(PixelOrigin origin, const DisparityMap& map) {
    return static_cast<double>(std::ranges::count(map.origins, origin)) /
           static_cast<double>(map.origins.size());
}

Json mesh_json(const SurfaceResult& surface) {
    const HexMesh2D& lattice = surface.lattice;
    const DeviceFigures& device = surface.device;
    const quality::MeshQuality& quality = surface.quality;
    return {{"columns", lattice.columns},
            {"rows", lattice.rows},
            {"vertices", static_cast<long long>(lattice.columns) * lattice.rows},
            {"triangles", lattice.triangle_count()},
            {"iterations", lattice.iterations},
            {"device_seconds", device.training_s},
            {"device_balance_seconds", device.balance_s},
            {"device_surface_seconds", device.surface_s},
            {"device_bytes", device.bytes},
            {"percent_cost", finite(quality.percent_cost)},
            {"max_deviation_percent", finite(quality.max_deviation_percent)},
            {"inverted_triangles", quality.inverted_triangles},
            {"min_angle_deg", finite(quality.min_angle_deg)},
            {"honeycomb_cells", quality.honeycomb_cells},
            // of their mean
            {"weights_percent",
             {{"p5", finite(quality.percentile5_weight_percent)},
              {"p50", finite(quality.percentile50_weight_percent)},
              {"p95", finite(quality.percentile95_weight_percent)}}},
            // the smallest of each triangle
            {"angles_deg",
             {{"min", finite(quality.min_angle_deg)},
              {"p1", finite(quality.percentile1_angle_deg)},
              {"median", finite(quality.median_angle_deg)}}}};
}

Json surface_json(const RunReport& report) {
    const SurfaceResult& surface = report.relief->surface;
    const auto& [low, high] = surface.bounds;
    Json json = {{"vertices", surface.mesh.positions.size()},
                 {"triangles", surface.mesh.triangles.size()},
                 {"components", report.topology.components},
                 {"boundary_loops", report.topology.boundary_loops},
                 {"bounds", {{low.x, low.y, low.z}, {high.x, high.y, high.z}}},
                 {"metric", surface.mesh.metric},
                 {"right_triangles", surface.mesh.triangles_of(PartOrigin::right)},
                 {"hidden_triangles", surface.mesh.triangles_of(PartOrigin::nobody)}};
    json.update(surface_figures_json(report.quality, report.holes));
    return json;
}

Json levels_json(const RunReport& report) {
    Json json = Json::array();
    double spacing_px = report.config().mesh.spacing_px;
    for (const SurfaceMesh& level : report.coarser)
        json.push_back({{"spacing_px", spacing_px *= 2},
                        {"vertices", level.positions.size()},
                        {"triangles", level.triangles.size()}});
    return json;
}

Json budget_json(const BudgetResult& budget) {
    if (budget.kind.empty()) return nullptr;
    return {{"kind", budget.kind},
            {"limit", budget.limit},
            {"reached", budget.reached},
            {"spacing_px", budget.spacing_px},
            {"tolerance_px", budget.tolerance_px},
            {"solves", budget.solves},
            {"texture_quality", budget.texture ? Json(budget.texture->quality) : Json(nullptr)},
            {"texture_max_px", budget.texture ? Json(budget.texture->max_px) : Json(nullptr)}};
}

// Paths need not be UTF-8: invalid bytes become U+FFFD instead of an exception.
std::string dump(const Json& json, int indent) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::size_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

}  // namespace

Json calibration_json(const Calibration& camera) {
    return {{"focal_px", camera.focal_px},
            {"cx", camera.cx},
            {"cy", camera.cy},
            {"baseline_m", camera.baseline_m},
            {"doffs_px", camera.doffs_px},
            {"metric", camera.metric}};
}

Json surface_figures_json(const stages::SurfaceQuality& quality, const stages::HoleShares& holes) {
    return {{"rmse_near_px", quality.rmse_near_px},
            {"duo_rmse_near_px", quality.duo_rmse_near_px},
            {"flat_rmse_px", quality.flat_rmse_px},
            {"sheet_share", quality.sheet_share},
            {"hole_share", holes.right},
            {"hole_share_above", holes.above},
            {"coverage", quality.coverage},
            {"slack_coverage", quality.slack_coverage}};
}

std::optional<OriginShares> origin_shares(const DisparityMap& map) {
    if (map.origins.empty()) return std::nullopt;
    return OriginShares{share_of(PixelOrigin::matched, map), share_of(PixelOrigin::filled, map)};
}

PictureShares shares_of(const Relief& relief) {
    const std::vector<std::uint8_t>& kept = relief.input.mask.kept;
    const std::size_t blank = relief.input.is_aligned() ? std::ranges::count(kept, 0) : 0;
    PictureShares shares = share_picture(relief.disparity.meshed(), relief.density.background_px,
                                         relief.surface.mesh, relief.surface.mesh.left_triangles(), blank);
    if (const InputMap* const map = relief.input.map(); map && map->is_depth)
        shares.unknown += std::exchange(shares.occluded, 0);
    return shares;
}

void take_measures(const std::vector<std::filesystem::path>& outputs, RunReport& report) {
    const SurfaceResult& surface = report.relief->surface;
    const LeftView view = report.relief->view();
    const int threads = report.relief->backend->threads();
    auto topology = start_work(threads, [&] { return stages::count_topology(surface.mesh); });
    report.quality = quality_as_written(view, surface, outputs, threads);
    report.holes = stages::measure_holes(surface.mesh, view.disparity,
                                         view.pair_camera.doffs_px - view.calibration.doffs_px, threads);
    report.topology = topology.get();
}

void take_figures(const RunLog& log, RunReport& report) {
    report.stage_seconds = log.stage_seconds();
    report.warnings = log.warnings();
    report.seconds = log.seconds();
    report.peak_bytes = peak_bytes();
}

std::string report_json(const RunReport& report) {
    const auto& [input, backend, backend_reason, disparity, pair_camera, density, right, surface] =
        *report.relief;
    Json json;
    json["schema"] = 1;
    json["hexrelief"]["version"] = HEXRELIEF_VERSION;
    if (!report.stamp.empty()) json["stamp"] = report.stamp;
    json["backend"] = backend->name();
    json["backend_reason"] = backend_reason + (backend->is_replaced() ? ", but the device failed" : "");
    json["device"] = backend->device();
    json["threads"] = backend->threads();
    json["seed"] = report.config().mesh.seed;
    json["config"] = config::config_json(report.config());
    json["input"] = input_json(report);
    json["foreground_share"] = report.shares.foreground;
    json["background_px"] = density.background_px;
    json["picture"] = picture_json(report.shares);
    json["depth_range"] = {surface.nearest(), surface.farthest()};
    json["disparity"] = matching_json(*report.relief);
    json["stages"] = Json::array();
    for (const auto& [name, seconds] : report.stage_seconds)
        json["stages"].push_back({{"name", name}, {"seconds", seconds}});
    json["mesh"] = mesh_json(surface);
    json["surface"] = surface_json(report);
    if (!report.coarser.empty()) json["levels"] = levels_json(report);
    json["budget"] = budget_json(surface.budget);
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
    parameters.erase("budget");  // its result is in the other keys
    Json& input = parameters["input"];
    input["calibration"].erase("file");
    if (input["disparity"]["key"] == "") input["disparity"].erase("key");
    // Sections and keys with default values are left out, so that files keep the bytes that they had
    // before these existed.
    const Json defaults = config::config_json({});
    for (const char* const section : {"rectify", "depth", "mask", "confidence"})
        if (input[section] == defaults["input"][section]) input.erase(section);
    for (const char* const key : {"up", "ply_texcoords"})
        parameters["export"].erase(key);  // of other formats
    Json& disparity = parameters["disparity"];
    if (disparity["working_px"] == defaults["disparity"]["working_px"]) disparity.erase("working_px");
    Json json;
    json["hexrelief"]["version"] = HEXRELIEF_VERSION;
    json["hexrelief"]["config"] = std::move(parameters);
    json["hexrelief"]["calibration"] = calibration_json(view.pair_camera);
    json["hexrelief"]["image"] = {{"width", view.disparity.width}, {"height", view.disparity.height}};
    if (view.up != LeftView::kUpright) json["hexrelief"]["up"] = view.up;
    json["hexrelief"]["percent_cost"] = finite(result.quality.percent_cost);
    return dump(json, -1);
}

}  // namespace hexrelief::job
