#include "pipeline/library/conversions.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <utility>

#include "pipeline/config/options.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "pipeline/job/cameras/resolve_calibration.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/job/run_files.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::library {
namespace {

// Returns `height` rows of `row` samples, without the gaps between rows.
template <typename Sample>
std::vector<Sample> rows_of(const void* from, std::size_t row, int height, std::size_t row_bytes) {
    std::vector<Sample> samples(row * static_cast<std::size_t>(height));
    const std::size_t bytes = row * sizeof(Sample), step = row_bytes > 0 ? row_bytes : bytes;
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
        std::memcpy(samples.data() + y * row, static_cast<const std::uint8_t*>(from) + y * step, bytes);
    return samples;
}

void require_pixels(const void* values, int width, int height, const std::string& name) {
    if (values == nullptr || width < 1 || height < 1)
        throw Error(ErrorKind::input, name + ": it has no pixels; give an array of height x width");
}

readers::codec::Raster raster_of(const ImageView& view, const std::string& name) {
    require_pixels(view.pixels, view.width, view.height, name);
    if (view.channels < 1 || view.channels > 4)
        throw Error(ErrorKind::input,
                    name + ": it has " + std::to_string(view.channels) +
                        " channels; give 1 (grey) or 3 (red, green, blue), with alpha 2 or 4");
    const std::size_t row = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.channels);
    readers::codec::Raster raster{view.width,
                                  view.height,
                                  view.channels,
                                  255,
                                  readers::codec::kNoData,
                                  rows_of<std::uint8_t>(view.pixels, row, view.height, view.row_bytes)};
    if (view.channels % 2 == 0) readers::codec::split_alpha(raster);
    return raster;
}

readers::codec::Raster raster_of(const MapView& view, const std::string& name) {
    require_pixels(view.values, view.width, view.height, name);
    readers::codec::Raster raster{.width = view.width, .height = view.height};
    const auto row = static_cast<std::size_t>(view.width);
    if (view.samples == MapView::Samples::float32)
        raster.samples = rows_of<float>(view.values, row, view.height, view.row_bytes);
    else if (view.samples == MapView::Samples::uint16)
        raster.samples = rows_of<std::uint16_t>(view.values, row, view.height, view.row_bytes);
    else
        raster.samples = rows_of<std::uint8_t>(view.values, row, view.height, view.row_bytes);
    return raster;
}

config::Config configured(const Options& options, const Camera& camera, const std::vector<std::string>& files,
                          const config::Config& base) {
    std::vector<std::string> settings;
    for (const auto& [key, value] : options.settings) settings.push_back(key + "=" + value);
    config::Config config = config::read_config(options.config, settings, base);
    const auto take = [&](const char* name, double value) {
        if (!std::isnan(value))
            config::apply_option(config, std::string("camera.") + name,
                                 std::string("input.calibration.") + name, value);
    };
    if (!camera.file.empty())
        config::apply_option(config, "camera.file", "input.calibration.file", camera.file);
    take("focal_px", camera.focal_px);
    take("baseline_m", camera.baseline_m);
    take("cx", camera.cx);
    take("cy", camera.cy);
    take("doffs_px", camera.doffs_px);
    apply_options(config, options.direct, files);
    return config;
}

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
           std::ranges::any_of(report.outputs, [](const job::OutputFile& file) {
               const exporters::MeshFormat* const format = exporters::find_mesh_format(file.path);
               return format && format->colours != exporters::ColourStorage::none;
           });
}

}  // namespace

Image image_of(const ImageView& view, const std::string& name) {
    readers::codec::Raster raster = raster_of(view, name);
    return {raster.width, raster.height, raster.channels,
            std::get<std::vector<std::uint8_t>>(std::move(raster.samples)), std::move(raster.alpha)};
}

readers::DisparityFile map_of(const MapView& view, const readers::DisparityFileConfig& config) {
    return readers::disparities_of(raster_of(view, "disparity"), "disparity", readers::before_doffs(config));
}

readers::DepthFile depth_of(const MapView& view, const readers::DepthFileConfig& config) {
    return readers::depths_of(raster_of(view, "depth"), "depth", config);
}

readers::PixelMask mask_of(const ImageView& view, const readers::MaskConfig& config) {
    return readers::mask_of(raster_of(view, "mask"), "mask", config);
}

readers::PixelMask confidence_of(const MapView& view, const readers::ConfidenceConfig& config) {
    return readers::confidence_of(raster_of(view, "confidence"), "confidence", config);
}

config::Config config_of(const Options& options, const Camera& camera,
                         const std::vector<std::string>& files) {
    config::Config config = configured(options, camera, files, {});
    if (options.config.empty())
        config = configured(options, camera, files, config::budget_base(config.budget));
    config::finish_config(config);
    return config;
}

void apply_export_settings(config::Config& config, const Options& options) {
    if (!options.config.empty())
        throw Error(ErrorKind::usage, "save() takes settings of 'export', not a configuration");
    for (const auto& [key, value] : options.settings) {
        if (!key.starts_with("export."))
            throw Error(ErrorKind::usage,
                        "'" + key + "' is not a setting of 'export'; give it where the mesh is made");
        config::apply_setting(config, key + "=" + value);
    }
    config::finish_config(config);
}

bool sets_tolerance(const Options& options) {
    return std::ranges::any_of(
        options.settings, [](const auto& setting) { return setting.first.starts_with("export.tolerance_"); });
}

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

void tell_caller(const Options& options, job::RunLog& log) {
    log.stage_begins = {};
    log.stage_progresses = {};
    if (options.progress) {
        const auto stage = std::make_shared<std::string>();
        log.stage_begins = [stage, tell = options.progress](const std::string& name) {
            tell(*stage = name, 0);
        };
        log.stage_progresses = [stage, tell = options.progress](double share) { tell(*stage, share); };
    }
    log.warns = options.warn;
    log.stage_ends = options.stage_ended;
    log.decides = options.decided;
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
