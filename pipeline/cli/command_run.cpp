#include <unistd.h>

#include <cstdio>
#include <memory>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/run_options.h"
#include "pipeline/cli/summary.h"
#include "pipeline/config/presets.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/job/run_files.h"

namespace hexrelief {
namespace {

constexpr const char* kExamples = R"(Examples:
  hexrelief run --left left.png --right right.png --calib calib.txt -o relief.glb
  hexrelief run --left l.png --right r.png -o relief.glb -o relief.obj --set export.compression=draco
  hexrelief run --disparity disp.png --disparity-scale 4 --color left.png -o relief.ply --report report.json
  hexrelief run --disparity disp0.pfm --config aloe.yaml -o relief.drc --save-stages stages
  hexrelief run --disparity disp0.pfm -o relief.drc --max-bytes 20000

The extension of an output gives its format: .glb .gltf .drc .obj .ply .stl .usdz .html
Settings apply in this order: defaults, --config, --set, direct options such as --seed.
Exit codes: 0 done, 2 usage or configuration, 3 input, 4 output, 5 device, 6 memory, 1 a bug,
130 interrupted.)";

void add_input_options(Command& command, RunOptions& options) {
    const char* const group = "Input";
    command.add_option("--left", &options.request.left,
                       "left image of a rectified pair (PNG, PPM, PGM, JPEG, TIFF, WebP)",
                       {.group = group, .value = "L"});
    command.add_option("--right", &options.request.right, "right image", {.group = group, .value = "R"});
    command.add_option("--stereo", &options.request.stereo, "both images in one file instead",
                       {.group = group, .value = "S"});
    command.add_option("--layout", &options.layout,
                       "how it holds them: auto (MPO), sbs, sbs-half, tb, tb-half",
                       {.group = group, .value = "NAME"});
    command.add_option("--disparity", &options.request.disparity,
                       "a disparity map of the left view instead (PNG, PGM, PFM, TIFF, NPY, NPZ, EXR)",
                       {.group = group, .value = "D"});
    command.add_option("--depth", &options.request.depth,
                       "a depth map instead: along the optical axis; 16-bit integers in mm, floats in m",
                       {.group = group, .value = "D"});
    command.add_option("--depth-unit", &options.depth_unit,
                       "m, mm, or a number: the depth map's samples divided by it are metres",
                       {.group = group, .value = "U"});
    command.add_option("--depth-kind", &options.depth_kind,
                       "depth, inverse_depth, or affine_inverse, as networks give for single pictures",
                       {.group = group, .value = "K"});
    command.add_option("--color", &options.request.color, "the left image for that map's texture",
                       {.group = group, .value = "L"});
    command.add_option("--mask", &options.request.mask,
                       "an image of the left view; where it is 0 the view is unknown",
                       {.group = group, .value = "M"});
    command.add_option("--confidence", &options.request.confidence,
                       "confidences of a map; below input.confidence.threshold it is unknown",
                       {.group = group, .value = "C"});
    command.add_option("--disparity-scale", &options.scale, "the map's samples divided by this are px",
                       {.group = group, .value = "S"});
    command.add_option("--disparity-offset", &options.offset_px, "px added after the scale",
                       {.group = group, .value = "O"});
    command.add_option("--unknown", &options.unknown, "sample that means 'not known' in the map",
                       {.group = group, .value = "V"});
    command.add_option("--key", &options.key,
                       "array of an NPZ, channel of an EXR that is the map, where there are several",
                       {.group = group, .value = "NAME"});
    command.add_option("--calib", &options.calibration,
                       "the camera: Middlebury calib.txt, KITTI, OpenCV YAML, a 3x3 matrix, ROS, Open3D, "
                       "RealSense or COLMAP",
                       {.group = group, .value = "C"});
    command.add_option("--fov-x", &options.fov_x_deg, "angle of view across the width, degrees, instead",
                       {.group = group, .value = "DEG"});
}

void add_output_options(Command& command, RunOptions& options) {
    const char* const group = "Output";
    command.add_option("-o,--output", &options.request.outputs,
                       "mesh file; may be given several times; - or glb:-, drc:-, ply:-, stl:-, usdz:-: to "
                       "the standard output",
                       {.group = group, .value = "OUT", .repeated = true});
    command.add_option("--report", &options.request.report,
                       "what was done, as JSON; - = to the standard output",
                       {.group = group, .value = "R.json"});
    command.add_option("--save-stages", &options.request.stages_folder, "each stage's result and pictures",
                       {.group = group, .value = "DIR"});
    command.add_flag("--quiet", options.quiet, "nothing but errors", {.group = group});
    command.add_flag("--verbose", options.verbose, "decisions and the seconds of each stage",
                     {.group = group, .excludes = "--quiet"});
}

void add_job_options(Command& command, RunOptions& options) {
    const char* const group = "Job";
    add_config_options(command, options.config, group);
    command.add_option("--vertices", &options.vertices,
                       "the finest mesh with at most N vertices; as --config compact where none is given",
                       {.group = group, .value = "N"});
    command.add_option("--max-bytes", &options.max_bytes,
                       "the best mesh and texture whose file has at most N bytes; likewise",
                       {.group = group, .value = "N"});
    command.add_option("--max-error-px", &options.max_error_px,
                       "the coarsest mesh whose error in both cameras' views is at most E px",
                       {.group = group, .value = "E"});
    command.add_option("--backend", &options.backend, "auto, cpu or cuda", {.group = group, .value = "B"});
    command.add_option("--threads", &options.threads, "CPU threads; 0 = all", {.group = group, .value = "N"});
    command.add_flag("--strict", options.strict, "an input that looks wrong is an error, not a warning",
                     {.group = group});
    command.add_option("--seed", &options.seed, "seed of all random draws", {.group = group, .value = "N"});
}

// Direct options are settings too, so that the field table checks their ranges.
Config configured(const RunOptions& options, const Config& base) {
    Config config = read_config(options.config, base);
    const auto set = [&](const char* option, const char* path, const std::string& value) {
        apply_option(config, option, path, value);
    };
    if (options.scale) set("--disparity-scale", "input.disparity.scale", shortest(*options.scale));
    if (options.offset_px)
        set("--disparity-offset", "input.disparity.offset_px", shortest(*options.offset_px));
    const bool is_depth = !options.request.depth.empty();
    if (!options.unknown.empty())
        set("--unknown", is_depth ? "input.depth.unknown" : "input.disparity.unknown", options.unknown);
    if (!options.key.empty()) set("--key", is_depth ? "input.depth.key" : "input.disparity.key", options.key);
    if (!options.depth_unit.empty()) set("--depth-unit", "input.depth.unit", options.depth_unit);
    if (!options.depth_kind.empty()) set("--depth-kind", "input.depth.kind", options.depth_kind);
    if (!options.calibration.empty()) set("--calib", "input.calibration.file", options.calibration);
    if (!options.layout.empty()) set("--layout", "input.stereo.layout", options.layout);
    if (options.fov_x_deg) set("--fov-x", "input.calibration.fov_x_deg", shortest(*options.fov_x_deg));
    if (!options.backend.empty()) set("--backend", "run.backend", options.backend);
    if (options.threads) set("--threads", "run.threads", std::to_string(*options.threads));
    if (options.vertices) set("--vertices", "budget.vertices", std::to_string(*options.vertices));
    if (options.max_bytes) set("--max-bytes", "budget.max_bytes", std::to_string(*options.max_bytes));
    if (options.max_error_px) set("--max-error-px", "budget.max_error_px", shortest(*options.max_error_px));
    if (options.strict) set("--strict", "run.strict", "true");
    if (options.seed) set("--seed", "mesh.seed", std::to_string(*options.seed));
    return config;
}

Config effective_config(const RunOptions& options) {
    Config config = configured(options, {});
    if (options.config.file.empty()) config = configured(options, budget_base(config.budget));
    finish_config(config);
    return config;
}

void refuse_options_without_their_file(const RunOptions& options) {
    const auto refuse = [](const std::string& option, const std::string& file) {
        throw Error(ErrorKind::usage, option + " goes with " + file + ", which is not given");
    };
    const bool is_disparity = !options.request.disparity.empty(), is_depth = !options.request.depth.empty();
    if (options.scale && !is_disparity) refuse("--disparity-scale", "--disparity");
    if (options.offset_px && !is_disparity) refuse("--disparity-offset", "--disparity");
    if (!options.depth_unit.empty() && !is_depth) refuse("--depth-unit", "--depth");
    if (!options.depth_kind.empty() && !is_depth) refuse("--depth-kind", "--depth");
    if (!options.key.empty() && !is_disparity && !is_depth) refuse("--key", "--disparity");
    if (!options.unknown.empty() && !is_disparity && !is_depth) refuse("--unknown", "--disparity");
}

// "-" is written as GLB, "drc:-" and the like as what they say.
std::filesystem::path standard_output_name(const std::filesystem::path& output) {
    const std::string name = output.string();
    if (name == "-") return "-.glb";
    return name.ends_with(":-") ? "-." + name.substr(0, name.size() - 2) : name;
}

}  // namespace

void add_run_options(Command& command, RunOptions& options) {
    add_input_options(command, options);
    add_output_options(command, options);
    add_job_options(command, options);
}

RunRequest request_of(const RunOptions& options) {
    if (!options.layout.empty() && options.request.stereo.empty())
        throw Error(ErrorKind::usage, "--layout goes with --stereo, which is not given");
    refuse_options_without_their_file(options);
    RunRequest request = options.request;
    for (std::filesystem::path& output : request.outputs) output = standard_output_name(output);
    request.config = effective_config(options);
    if (!find_preset(options.config.file)) request.config_file = options.config.file;
    return request;
}

void run_and_tell(const RunRequest& request, const RunOptions& options, const BackendPicker& pick) {
    const double begun = now_seconds();
    const bool verbose = options.verbose;
    ProgressLine progress(!options.quiet && !verbose && isatty(STDERR_FILENO));
    RunObserver observer;
    observer.stage_begins = [&](const std::string& stage) { progress.begin(stage); };
    observer.stage_progresses = [&](double share) { progress.update(share); };
    observer.stage_ends = [&](const std::string& stage, double seconds) {
        progress.end();
        if (verbose) std::fprintf(stderr, "%-10s %8.3f s\n", stage.c_str(), seconds);
    };
    if (verbose)
        observer.decides = [](const std::string& decision) {
            std::fprintf(stderr, "  %s\n", decision.c_str());
        };
    if (!options.quiet) {
        observer.warns = [&](const std::string& warning) {
            progress.break_line();
            print_warning(warning);
        };
    }
    const RunReport report = run_job(request, observer, pick);
    if (verbose) {
        const double full = 2.0 * (report.width - 1) * (report.height - 1);
        std::fprintf(stderr,
                     "  %%cost %.2f, 1 of %.1f triangles of the full grid, %d threads on %s, peak memory "
                     "%zu MiB\n",
                     report.quality.percent_cost, full / static_cast<double>(report.triangles),
                     report.threads, report.device.c_str(), report.peak_bytes >> 20);
    }
    if (options.quiet) return;
    std::fputs(summary_of(report, request, now_seconds() - begun).c_str(),
               writes_standard_output(request) ? stderr : stdout);
}

void add_run_command(Command& program) {
    Command command = program.add_command("run", "a stereo pair or a disparity map to mesh files");
    const auto options = std::make_shared<RunOptions>();
    add_run_options(command, *options);
    command.set_footer(kExamples);
    command.set_action([options] {
        const RunRequest request = request_of(*options);
        install_interrupt_handling();
        run_and_tell(request, *options, pick_for_one_run());
        return 0;
    });
}

}  // namespace hexrelief
