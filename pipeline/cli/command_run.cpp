#include <hexrelief/run.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/cli/commands.h"
#include "pipeline/cli/manual.h"
#include "pipeline/cli/piped_inputs.h"
#include "pipeline/cli/printable.h"
#include "pipeline/cli/run_options.h"
#include "pipeline/data/error.h"

namespace hexrelief::cli {
namespace {

// Returns "1 234 567".
std::string grouped(std::uint64_t value) {
    std::string digits = std::to_string(value);
    for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3)
        digits.insert(digits.begin() + at, ' ');
    return digits;
}

template <typename... Values>
std::string text(const char* format, Values... values) {
    char buffer[256];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

std::string budget_line(const RunSummary::Budget& budget) {
    const auto number = [&](double value) {
        return budget.kind == "max_error_px" ? text("%.6g", value)
                                             : grouped(static_cast<std::uint64_t>(value));
    };
    return "budget " + budget.kind + " " + number(budget.limit) + ": reached " + number(budget.reached) +
           text(" at a spacing of %.6g px, in %d solves\n", budget.spacing_px, budget.solves);
}

std::string files_line(const RunSummary& run, const FileRequest& request) {
    std::string line;
    const auto add = [&](const std::string& file) { line += (line.empty() ? "" : ", ") + file; };
    for (const RunSummary::File& file : run.outputs)
        add(printable(file.path) + " " + grouped(file.bytes) + " bytes");
    if (!request.report.empty()) add("report " + printable(request.report));
    if (!request.stages_folder.empty()) add("stages in " + printable(request.stages_folder));
    return line + "\n";
}

// Returns the shares, without those that would be printed as 0.
std::string shares_text(const RunSummary& run) {
    std::string line = text("%.1f %% of the picture is meshed", 100 * run.meshed);
    const char* before = "; of its map ";
    const auto add = [&](const char* name, double share) {
        if (share < 0.0005) return;
        line += before + text("%.1f %% is %s", 100 * share, name);
        before = ", ";
    };
    add("background", run.background);
    add("unknown", run.unknown);
    add("occluded", run.occluded);
    if (run.on_backdrop >= 0.0005)
        line += text("; %.1f %% seemed beyond the matches' %.3g%s and lies there", 100 * run.on_backdrop,
                     run.backdrop, run.is_metric ? " m" : "");
    return line;
}

// Returns the summary: a line each for a budget, a photograph's own camera
// and an alignment if there is one; a line with the files written and their bytes;
// and a line with the mesh, its depths, the share of the picture that it covers, and the shares that it does
// not. `seconds`: the run's time.
std::string summary_text(const RunSummary& run, const FileRequest& request, double seconds) {
    std::string summary = run.budget.kind.empty() ? "" : budget_line(run.budget);
    if (!run.camera.empty()) summary += "camera: " + run.camera + "\n";
    if (!run.alignment.empty()) summary += run.alignment + "\n";
    summary += files_line(run, request);
    summary += grouped(run.vertices) + " vertices, " + grouped(run.triangles) + " triangles";
    if (run.lacks_color) summary += " without colours (--color gives some)";
    summary +=
        text(", depth %.3g to %.3g%s; ", run.nearest, run.farthest, run.is_metric ? " m" : " (relative)");
    if (!run.read_as.empty()) summary += "read as " + run.read_as + "; ";
    summary += shares_text(run);
    if (!run.support.empty()) summary += "; support by the pair: " + run.support;
    if (run.is_filled)
        summary +=
            text("; %.1f %% was measured, %.1f %% filled between", 100 * run.measured, 100 * run.filled);
    if (run.reduced_by > 1)
        summary += text("; matched and meshed at %d x %d px, 1/%d of the picture's size", run.width,
                        run.height, run.reduced_by);
    summary += "; " + run.backend;
    if (run.device_bytes > 0) summary += " (" + grouped(run.device_bytes >> 10) + " KiB)";
    return summary + text(", %.2f s\n", seconds);
}

constexpr const char* kExamples = R"(Examples:
  hexrelief run --left left.png --right right.png --calib calib.txt -o relief.glb
  hexrelief run --left l.png --right r.png -o relief.glb -o relief.obj --set export.compression=draco
  hexrelief run --disparity disp.png --disparity-scale 4 --color left.png -o relief.ply --report report.json
  hexrelief run --disparity disp0.pfm --config aloe.yaml -o relief.drc --save-stages stages
  hexrelief run --disparity disp0.pfm -o relief.drc --max-bytes 20000

The extension of an output gives its format: )";

constexpr const char* kRules = R"(
Settings apply in this order: defaults, --config, --set, direct options such as --seed.
)";

std::string exit_codes() {
    std::string text;
    for (const auto& [code, meaning] : kExitCodes)
        text += (text.empty() ? "Exit codes: " : ", ") + std::to_string(code) + " " + meaning;
    return text + ".";
}

void add_input_options(Command& command, FileRequest& files, Options& options) {
    const char* const group = "Input";
    for (const auto& [flag, value, help, file] : file_options())
        command.add_option(flag, &(files.*file), help, {.group = group, .value = value});
    add_key_options(command, options, config::option_flags(group), group);
}

void add_output_options(Command& command, FileRequest& files, Options& options, Verbosity& verbosity) {
    const char* const group = "Output";
    command.add_option(
        "-o,--output", &files.outputs,
        "mesh file; may be given several times; - or " + output_streams() + ": to the standard output",
        {.group = group, .value = "OUT", .repeated = true});
    command.add_option("--report", &files.report, "what was done, as JSON; - = to the standard output",
                       {.group = group, .value = "R.json"});
    command.add_flag("--update", files.update,
                     "do nothing where the report says that all is there, of these inputs and settings",
                     {.group = group});
    command.add_option("--depfile", &files.depfile,
                       "a rule for make: the outputs depend on all files that are read",
                       {.group = group, .value = "FILE.d"});
    command.add_option("--save-stages", &files.stages_folder, "each stage's result and pictures",
                       {.group = group, .value = "DIR"});
    add_key_options(command, options, config::option_flags(group), group);
    const auto set = [&verbosity](Verbosity value) {
        return [&verbosity, value](const std::string&) { verbosity = value; };
    };
    command.add_option("--quiet", set(Verbosity::quiet), "nothing but errors", {.group = group});
    command.add_option("--verbose", set(Verbosity::verbose), "decisions and the seconds of each stage",
                       {.group = group, .excludes = "--quiet"});
}

void add_job_options(Command& command, Options& options) {
    const char* const group = "Job";
    add_config_options(command, options, group);
    add_key_options(command, options, config::option_flags(group), group);
}

}  // namespace

const std::vector<FileOption>& file_options() {
    static const std::vector<FileOption> options = {
        {"--left", "L", "left image of a pair (" + image_formats() + ")", &FileRequest::left},
        {"--right", "R", "right image", &FileRequest::right},
        {"--stereo", "S", "both images in one file instead", &FileRequest::stereo},
        {"--disparity", "D", "a disparity map of the left view instead (" + map_formats() + ")",
         &FileRequest::disparity},
        {"--depth", "D", "a depth map instead: along the optical axis; 16-bit integers in mm, floats in m",
         &FileRequest::depth},
        {"--color", "L", "the left image for that map's texture", &FileRequest::color},
        {"--disparity-right", "D", "the right view's map, beside --disparity, read as that",
         &FileRequest::disparity_right},
        {"--color-right", "R", "the right image for that map; without one it checks the left map",
         &FileRequest::color_right},
        {"--mask", "M", "an image of the left view; where it is 0 the view is unknown", &FileRequest::mask},
        {"--confidence", "C", "confidences of a map; below input.confidence.threshold it is unknown",
         &FileRequest::confidence},
    };
    return options;
}

void add_run_options(Command& command, FileRequest& files, Options& options, Verbosity& verbosity) {
    add_input_options(command, files, options);
    add_output_options(command, files, options, verbosity);
    add_job_options(command, options);
}

Options told_on_terminal(Options options, Verbosity verbosity, ProgressLine& progress) {
    const bool verbose = verbosity == Verbosity::verbose,
               shows = verbosity == Verbosity::summary && isatty(STDERR_FILENO);
    if (shows)
        options.progress = [&](const std::string& stage, double share) { progress.show(stage, share); };
    options.stage_ended = [&, verbose, shows](const std::string& stage, double seconds) {
        if (shows) progress.end(stage);
        if (verbose) std::fprintf(stderr, "%-10s %8.3f s\n", stage.c_str(), seconds);
    };
    if (verbose)
        options.decided = [](const std::string& decision) {
            std::fprintf(stderr, "  %s\n", printable(decision).c_str());
        };
    if (verbosity != Verbosity::quiet)
        options.warn = [&](const std::string& warning) {
            progress.break_line();
            print_warning(warning);
        };
    return options;
}

namespace {

// Throws Error(usage) if one of the outputs is the standard output, and that is a terminal.
void refuse_terminal(const std::vector<std::string>& outputs) {
    for (const std::string& output : outputs)
        if (isatty(STDOUT_FILENO) && uses_standard_output({.outputs = {output}}))
            throw Error(ErrorKind::usage,
                        "-o " + output +
                            ": the standard output is a terminal, which cannot show a mesh; "
                            "redirect it, as in '-o - > relief.glb'");
}

void run_files_and_tell(const FileRequest& files, const Options& options, Verbosity verbosity) {
    const auto begun = std::chrono::steady_clock::now();
    const bool quiet = verbosity == Verbosity::quiet, verbose = verbosity == Verbosity::verbose;
    ProgressLine progress;
    const RunSummary summary = run(files, told_on_terminal(options, verbosity, progress));
    if (summary.is_up_to_date) {
        if (!quiet) std::printf("%s: up to date\n", printable(files.report).c_str());
        return end_telling();
    }
    if (verbose) {
        const double full = 2.0 * (summary.width - 1) * (summary.height - 1);
        std::fprintf(stderr,
                     "  %%cost %.2f, 1 of %.1f triangles of the full grid, %d threads on %s, peak memory "
                     "%zu MiB\n",
                     summary.percent_cost, full / static_cast<double>(summary.triangles), summary.threads,
                     summary.device.c_str(), summary.peak_bytes >> 20);
    }
    if (quiet) return;
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begun;
    std::fputs(summary_text(summary, files, taken.count()).c_str(),
               uses_standard_output(files) ? stderr : stdout);
    if (!uses_standard_output(files)) end_telling();
}

}  // namespace

void run_and_tell(const FileRequest& files, const Options& options, Verbosity verbosity) {
    refuse_terminal(files.outputs);
    PipedInputs pipes;
    FileRequest read = files;
    for (const FileOption& option : file_options()) read.*option.file = pipes.file_of(read.*option.file);
    try {
        run_files_and_tell(read, options, verbosity);
    } catch (const Error& error) {
        throw Error(error.kind(), pipes.named(error.what()));
    }
}

void add_run_command(Command& program) {
    Command command = program.add_command("run", "a stereo pair or a disparity map to mesh files");
    struct Run {
        FileRequest files;
        Options options;
        Verbosity verbosity = Verbosity::summary;
    };
    const auto run = std::make_shared<Run>();
    add_run_options(command, run->files, run->options, run->verbosity);
    command.set_footer(kExamples + output_extensions() + kRules + exit_codes());
    command.set_action([run] {
        run->files.ends_process = true;
        end_on_interrupt();
        run_and_tell(run->files, run->options, run->verbosity);
        return 0;
    });
}

}  // namespace hexrelief::cli
