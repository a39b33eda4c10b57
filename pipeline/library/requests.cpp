#include "pipeline/library/requests.h"

#include <algorithm>
#include <filesystem>

#include "pipeline/config/presets.h"
#include "pipeline/data/error.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/job/run_files.h"
#include "pipeline/library/conversions.h"
#include "pipeline/readers/codecs.h"

namespace hexrelief::library {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorKind::usage, what);
}

// Returns the source that the given names make up. Throws Error(usage) if they do not go together.
job::Source source_of(const FileRequest& files) {
    const bool pair = !files.left.empty() || !files.right.empty();
    if (!files.disparity.empty() && !files.depth.empty())
        refuse("give either --disparity or --depth, not both");
    const bool map = !files.disparity.empty() || !files.depth.empty();
    const bool stereo = !files.stereo.empty();
    if (stereo && (pair || map || !files.color.empty()))
        refuse(
            "--stereo holds both views; give it without --left, --right, --disparity, --depth and --color");
    if ((pair || stereo) && !files.confidence.empty())
        refuse(
            "--confidence goes with --disparity or --depth; a pair's matches are checked as they are made");
    if (!files.disparity_right.empty() && files.color_right.empty() && !files.color.empty())
        refuse("--disparity-right needs --color-right, as --disparity has --color");
    if (!files.color_right.empty() && files.color.empty() && files.disparity_right.empty())
        refuse("--color-right needs --color, the picture of the map's own view");
    if (files.disparity.empty() && !(files.disparity_right + files.color_right).empty())
        refuse("--disparity-right and --color-right go with --disparity, which is the left view's map");
    if (stereo) return job::StereoFile{files.stereo, files.mask};
    if (map && !files.left.empty() && files.right.empty())
        refuse("a map takes its colours from --color: give --color " + files.left + " in place of --left");
    if (pair && map) refuse("give either --left and --right, or --disparity or --depth, not both");
    if (!pair && !map) refuse("nothing to do: give --left and --right, --stereo, --disparity, or --depth");
    if (pair && files.left.empty()) refuse("--right needs --left");
    if (pair && files.right.empty()) refuse("--left needs --right");
    if (pair && !files.color.empty())
        refuse("--color goes with --disparity or --depth; a pair takes its colours from --left");
    if (pair) return job::PairFiles{files.left, files.right, files.mask};
    if (!files.depth.empty()) return job::DepthFiles{files.depth, files.color, files.mask, files.confidence};
    return job::DisparityFiles{files.disparity,  files.color,           files.mask,
                               files.confidence, files.disparity_right, files.color_right};
}

// Returns the options of the files that are given, as far as other options go with them.
std::vector<std::string> given_files(const FileRequest& files) {
    std::vector<std::string> given;
    if (!files.stereo.empty()) given.emplace_back("--stereo");
    if (!files.disparity.empty()) given.emplace_back("--disparity");
    if (!files.depth.empty()) given.emplace_back("--depth");
    return given;
}

// Returns the output's name for the standard output: "-.glb" for "-", and "-" with the format's extension for
// "drc:-" and the like.
std::filesystem::path standard_output_name(const std::string& name) {
    if (name == "-") return "-.glb";
    return name.ends_with(":-") ? "-." + name.substr(0, name.size() - 2) : name;
}

// Returns a request with the places of its outputs; its source is still to be set.
job::RunRequest request_to(const FileRequest& files) {
    job::RunRequest request;
    for (const std::string& output : files.outputs) request.outputs.push_back(standard_output_name(output));
    request.report = files.report;
    request.depfile = files.depfile;
    request.stages_folder = files.stages_folder;
    request.jobs = files.runs;
    return request;
}

// True if an output could hold colours, and there is no picture for them.
bool lacks_color(const job::RunReport& report) {
    return report.relief->input.texture().empty() &&
           report.config().exporting.texture != exporters::TextureFormat::none &&
           std::any_of(report.outputs.begin(), report.outputs.end(), [](const job::OutputFile& file) {
               const exporters::MeshFormat* const format = exporters::find_mesh_format(file.path);
               return format && format->colours != exporters::ColourStorage::none;
           });
}

}  // namespace

job::RunRequest request_of(const FileRequest& files, const Options& options) {
    if (files.update && (files.report.empty() || files.report == "-"))
        refuse("--update goes with --report FILE, which says what was done");
    job::RunRequest request = request_to(files);
    request.config = config_of(options, {}, given_files(files));
    for (const std::string& name : options.config)
        if (!config::find_preset(name)) request.config_files.emplace_back(name);
    request.source = source_of(files);
    return request;
}

RunSummary summary_of(const job::RunReport& report) {
    const job::Relief& relief = *report.relief;
    const job::SurfaceResult& surface = relief.surface;
    const job::BudgetResult& budget = surface.budget;
    RunSummary summary;
    for (const job::OutputFile& file : report.outputs) summary.outputs.push_back({file.path, file.bytes});
    summary.width = relief.disparity.map.width;
    summary.height = relief.disparity.map.height;
    summary.reduced_by = relief.input.reduced_by();
    summary.vertices = surface.mesh.positions.size();
    summary.triangles = surface.mesh.triangles.size();
    summary.percent_cost = surface.quality.percent_cost;
    summary.nearest = surface.nearest();
    summary.farthest = surface.farthest();
    summary.is_metric = surface.mesh.metric;
    const job::RunInput& input = relief.input;
    if (input.map()) summary.read_as = input.map()->read_as;
    if (input.is_aligned())
        summary.alignment =
            job::alignment_text(*input.pair()->alignment, input.calibration, input.focal_from);
    if (input.focal_from == job::kOwnCamera || input.baseline_from == job::kOwnCamera)
        summary.camera = input.camera_text();
    summary.meshed = report.shares.meshed;
    summary.background = report.shares.background;
    summary.unknown = report.shares.unknown;
    summary.occluded = report.shares.occluded;
    summary.support = relief.support();
    if (relief.disparity.backdrop) summary.on_backdrop = relief.disparity.backdrop->moved_share;
    summary.backdrop = relief.depth_of_backdrop();
    if (const auto shares = job::origin_shares(relief.disparity.map); shares && !relief.disparity.matched) {
        summary.is_filled = true;
        summary.measured = shares->measured;
        summary.filled = shares->filled;
    }
    summary.lacks_color = lacks_color(report);
    summary.budget = {budget.kind,       budget.limit,        budget.reached,
                      budget.spacing_px, budget.tolerance_px, budget.solves};
    summary.backend = relief.backend->name();
    summary.device = relief.backend->device();
    summary.threads = relief.backend->threads();
    summary.device_bytes = surface.device.bytes;
    summary.peak_bytes = report.peak_bytes;
    return summary;
}

}  // namespace hexrelief::library

namespace hexrelief {
inline namespace v0 {

bool uses_standard_output(const FileRequest& files) {
    return job::writes_standard_output(library::request_to(files));
}
std::string image_formats() {
    return readers::codec::names_of(readers::codec::kPicture);
}
std::string map_formats() {
    return readers::codec::names_of(readers::codec::kMap);
}
std::string output_extensions() {
    return exporters::export_extensions();
}
std::string output_streams() {
    return job::standard_output_names();
}

}  // namespace v0
}  // namespace hexrelief
