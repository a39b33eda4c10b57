#include "pipeline/library/requests.h"

#include <algorithm>
#include <filesystem>

#include "pipeline/config/presets.h"
#include "pipeline/data/error.h"
#include "pipeline/job/run_files.h"
#include "pipeline/library/arguments.h"

namespace hexrelief {
namespace {

void refuse_options_without_their_file(const FileRequest& files, const Options& options) {
    const bool is_depth = !files.depth.empty(), is_map = is_depth || !files.disparity.empty();
    const auto need = [&](const std::string& option, bool is_given, const std::string& file) {
        const bool is_asked = std::any_of(options.direct.begin(), options.direct.end(),
                                          [&](const auto& direct) { return direct.first == option; });
        if (is_asked && !is_given)
            throw Error(ErrorKind::usage, option + " goes with " + file + ", which is not given");
    };
    need("--layout", !files.stereo.empty(), "--stereo");
    need("--disparity-scale", !files.disparity.empty(), "--disparity");
    need("--disparity-offset", !files.disparity.empty(), "--disparity");
    need("--depth-unit", is_depth, "--depth");
    need("--depth-kind", is_depth, "--depth");
    need("--key", is_map, "--disparity or --depth");
    need("--unknown", is_map, "--disparity or --depth");
}

// "-" is written as GLB, "drc:-" and the like as what they say.
std::filesystem::path standard_output_name(const std::string& name) {
    if (name == "-") return "-.glb";
    return name.ends_with(":-") ? "-." + name.substr(0, name.size() - 2) : name;
}

bool lacks_color(const RunRequest& request) {
    return request.left.empty() && request.stereo.empty() && request.color.empty() &&
           request.config.exporting.texture != TextureFormat::none &&
           std::any_of(request.outputs.begin(), request.outputs.end(), [](const std::filesystem::path& path) {
               return export_format(path).colours != ColourStorage::none;
           });
}

}  // namespace

RunRequest request_of(const FileRequest& files, const Options& options) {
    refuse_options_without_their_file(files, options);
    if (files.update && (files.report.empty() || files.report == "-"))
        throw Error(ErrorKind::usage, "--update goes with --report FILE, which says what was done");
    RunRequest request;
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
    request.config = config_of(options, {}, !files.depth.empty());
    if (!find_preset(options.config)) request.config_file = options.config;
    return request;
}

inline namespace v0 {

bool uses_standard_output(const FileRequest& files) {
    RunRequest request;
    for (const std::string& output : files.outputs) request.outputs.push_back(standard_output_name(output));
    request.report = files.report;
    return writes_standard_output(request);
}

std::string output_extensions() {
    return export_extensions();
}
std::string output_streams() {
    return standard_output_names();
}

}  // namespace v0

RunSummary summary_of(const RunReport& report, const RunRequest& request) {
    RunSummary summary;
    for (const OutputFile& file : report.outputs) summary.outputs.push_back({file.path, file.bytes});
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
    const BudgetResult& budget = report.budget;
    summary.budget = {budget.kind,       budget.limit,        budget.reached,
                      budget.spacing_px, budget.tolerance_px, budget.solves};
    summary.backend = report.backend;
    summary.device = report.device;
    summary.threads = report.threads;
    summary.device_bytes = report.device_bytes;
    summary.peak_bytes = report.peak_bytes;
    return summary;
}

}  // namespace hexrelief
