#include "pipeline/library/requests.h"

#include <algorithm>
#include <filesystem>

#include "pipeline/config/presets.h"
#include "pipeline/data/error.h"
#include "pipeline/job/run_files.h"
#include "pipeline/library/conversions.h"

namespace hexrelief::library {
namespace {

// The options of the files that are given, as far as other options go with them.
std::vector<std::string> given_files(const FileRequest& files) {
    std::vector<std::string> given;
    if (!files.stereo.empty()) given.emplace_back("--stereo");
    if (!files.disparity.empty()) given.emplace_back("--disparity");
    if (!files.depth.empty()) given.emplace_back("--depth");
    return given;
}

// "-" is written as GLB, "drc:-" and the like as what they say.
std::filesystem::path standard_output_name(const std::string& name) {
    if (name == "-") return "-.glb";
    return name.ends_with(":-") ? "-." + name.substr(0, name.size() - 2) : name;
}

bool lacks_color(const job::RunRequest& request) {
    return request.left.empty() && request.stereo.empty() && request.color.empty() &&
           request.config.exporting.texture != exporters::TextureFormat::none &&
           std::any_of(request.outputs.begin(), request.outputs.end(), [](const std::filesystem::path& path) {
               return exporters::export_format(path) != exporters::MeshFormat::drc;
           });
}

}  // namespace

job::RunRequest request_of(const FileRequest& files, const Options& options) {
    if (files.update && (files.report.empty() || files.report == "-"))
        throw Error(ErrorKind::usage, "--update goes with --report FILE, which says what was done");
    job::RunRequest request;
    request.left = files.left;
    request.right = files.right;
    request.stereo = files.stereo;
    request.disparity = files.disparity;
    request.depth = files.depth;
    request.color = files.color;
    request.mask = files.mask;
    request.confidence = files.confidence;
    for (const std::string& output : files.outputs) request.outputs.push_back(standard_output_name(output));
    request.report = files.report;
    request.depfile = files.depfile;
    request.stages_folder = files.stages_folder;
    request.jobs = files.runs;
    request.config = config_of(options, {}, given_files(files));
    if (!config::find_preset(options.config)) request.config_file = options.config;
    return request;
}

RunSummary summary_of(const job::RunReport& report, const job::RunRequest& request) {
    RunSummary summary;
    for (const job::OutputFile& file : report.outputs) summary.outputs.push_back({file.path, file.bytes});
    summary.width = report.width;
    summary.height = report.height;
    summary.vertices = report.vertices;
    summary.triangles = report.triangles;
    summary.percent_cost = report.quality.percent_cost;
    summary.nearest = report.nearest();
    summary.farthest = report.farthest();
    summary.is_metric = report.calibration.metric;
    summary.meshed = report.shares.meshed;
    summary.background = report.shares.background;
    summary.unknown = report.shares.unknown;
    summary.occluded = report.shares.occluded;
    if (report.filling) {
        summary.is_filled = true;
        summary.measured = report.filling->measured_share;
        summary.filled = report.filling->filled_share;
    }
    summary.lacks_color = lacks_color(request);
    const budget::BudgetResult& budget = report.budget;
    summary.budget = {budget.kind,       budget.limit,        budget.reached,
                      budget.spacing_px, budget.tolerance_px, budget.solves};
    summary.backend = report.backend;
    summary.device = report.device;
    summary.threads = report.threads;
    summary.device_bytes = report.device_bytes;
    summary.peak_bytes = report.peak_bytes;
    return summary;
}

}  // namespace hexrelief::library

namespace hexrelief {
inline namespace v0 {

bool uses_standard_output(const FileRequest& files) {
    job::RunRequest request;
    for (const std::string& output : files.outputs)
        request.outputs.push_back(library::standard_output_name(output));
    request.report = files.report;
    return job::writes_standard_output(request);
}

}  // namespace v0
}  // namespace hexrelief
