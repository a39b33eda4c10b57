#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <memory>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/commands.h"
#include "pipeline/cli/run_options.h"
#include "pipeline/cli/summary.h"
#include "pipeline/cli/terminal/printable.h"
#include "pipeline/cli/terminal/progress.h"

namespace hexrelief {
namespace {

constexpr const char* kExamples = R"(Examples:
  hexrelief run --left left.png --right right.png --calib calib.txt -o relief.glb
  hexrelief run --left l.png --right r.png -o relief.glb -o relief.obj --set export.compression=draco
  hexrelief run --disparity disp.png --disparity-scale 4 --color left.png -o relief.ply --report report.json
  hexrelief run --disparity disp0.pfm --config aloe.yaml -o relief.drc --save-stages stages
  hexrelief run --disparity disp0.pfm -o relief.drc --max-bytes 20000

The extension of an output gives its format: )";

constexpr const char* kRules = R"(
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
                       "how it holds them: auto (mpo where it is one), sbs, sbs-half, tb, tb-half, mpo",
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
    command.add_option(
        "-o,--output", &options.request.outputs,
        "mesh file; may be given several times; - or " + output_streams() + ": to the standard output",
        {.group = group, .value = "OUT", .repeated = true});
    command.add_option("--report", &options.request.report,
                       "what was done, as JSON; - = to the standard output",
                       {.group = group, .value = "R.json"});
    command.add_flag("--update", options.request.update,
                     "do nothing where the report says that all is there, of these inputs and settings",
                     {.group = group});
    command.add_option("--depfile", &options.request.depfile,
                       "a rule for make: the outputs depend on all files that are read",
                       {.group = group, .value = "FILE.d"});
    command.add_option("--save-stages", &options.request.stages_folder, "each stage's result and pictures",
                       {.group = group, .value = "DIR"});
    command.add_flag("--quiet", options.quiet, "nothing but errors", {.group = group});
    command.add_flag("--verbose", options.verbose, "decisions and the seconds of each stage",
                     {.group = group, .excludes = "--quiet"});
}

void add_job_options(Command& command, RunOptions& options) {
    const char* const group = "Job";
    add_config_options(command, options.config, group);
    command.add_option(
        "--vertices", &options.vertices,
        "the finest mesh with at most N vertices, made as by --config compact where none is given",
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

std::string text_of(int value) {
    return std::to_string(value);
}
std::string text_of(long long value) {
    return std::to_string(value);
}
std::string text_of(double value) {
    return shortest(value);
}

}  // namespace

void add_run_options(Command& command, RunOptions& options) {
    add_input_options(command, options);
    add_output_options(command, options);
    add_job_options(command, options);
}

Options options_of(const RunOptions& options) {
    Options said{.config = options.config.file};
    for (const std::string& setting : options.config.settings) {
        const std::size_t equals = setting.find('=');
        if (equals == std::string::npos)
            throw Error(ErrorKind::usage, "--set " + setting + ": write it as key.path=value");
        said.settings.emplace_back(setting.substr(0, equals), setting.substr(equals + 1));
    }
    const auto text = [&](const char* option, const std::string& value) {
        if (!value.empty()) said.direct.emplace_back(option, value);
    };
    const auto number = [&](const char* option, const auto& value) {
        if (value) said.direct.emplace_back(option, text_of(*value));
    };
    number("--disparity-scale", options.scale);
    number("--disparity-offset", options.offset_px);
    text("--unknown", options.unknown);
    text("--key", options.key);
    text("--depth-unit", options.depth_unit);
    text("--depth-kind", options.depth_kind);
    text("--calib", options.calibration);
    text("--layout", options.layout);
    number("--fov-x", options.fov_x_deg);
    text("--backend", options.backend);
    number("--threads", options.threads);
    number("--vertices", options.vertices);
    number("--max-bytes", options.max_bytes);
    number("--max-error-px", options.max_error_px);
    if (options.strict) said.direct.emplace_back("--strict", "true");
    number("--seed", options.seed);
    return said;
}

void check_run(const RunOptions& options) {
    check_run(options.request, options_of(options));
}

void run_and_tell(const RunOptions& options) {
    const auto begun = std::chrono::steady_clock::now();
    const bool verbose = options.verbose;
    Options said = options_of(options);
    ProgressLine progress(!options.quiet && !verbose && isatty(STDERR_FILENO));
    std::string shown;  // the stage that the line tells of
    said.progress = [&](const std::string& stage, double share) {
        if (shown == stage)
            progress.update(share);
        else
            progress.begin(shown = stage);
    };
    said.stage_ended = [&](const std::string& stage, double seconds) {
        progress.end();
        shown.clear();
        if (verbose) std::fprintf(stderr, "%-10s %8.3f s\n", stage.c_str(), seconds);
    };
    if (verbose)
        said.decided = [](const std::string& decision) {
            std::fprintf(stderr, "  %s\n", printable(decision).c_str());
        };
    if (!options.quiet)
        said.warn = [&](const std::string& warning) {
            progress.break_line();
            print_warning(warning);
        };
    const RunSummary summary = run(options.request, said);
    if (summary.is_up_to_date) {
        if (!options.quiet) std::printf("%s: up to date\n", printable(options.request.report).c_str());
        return;
    }
    if (verbose) {
        const double full = 2.0 * (summary.width - 1) * (summary.height - 1);
        std::fprintf(stderr,
                     "  %%cost %.2f, 1 of %.1f triangles of the full grid, %d threads on %s, peak memory "
                     "%zu MiB\n",
                     summary.percent_cost, full / static_cast<double>(summary.triangles), summary.threads,
                     summary.device.c_str(), summary.peak_bytes >> 20);
    }
    if (options.quiet) return;
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begun;
    std::fputs(summary_text(summary, options.request, taken.count()).c_str(),
               uses_standard_output(options.request) ? stderr : stdout);
}

void add_run_command(Command& program) {
    Command command = program.add_command("run", "a stereo pair or a disparity map to mesh files");
    const auto options = std::make_shared<RunOptions>();
    add_run_options(command, *options);
    command.set_footer(kExamples + output_extensions() + kRules);
    command.set_action([options] {
        options->request.ends_process = true;
        end_on_interrupt();
        run_and_tell(*options);
        return 0;
    });
}

}  // namespace hexrelief
