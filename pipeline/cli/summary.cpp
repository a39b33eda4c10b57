#include "pipeline/cli/summary.h"

#include <cstdio>

#include "pipeline/cli/terminal/printable.h"

namespace hexrelief::cli {
namespace {

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

}  // namespace

std::string grouped(std::uint64_t value) {
    std::string digits = std::to_string(value);
    for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3)
        digits.insert(digits.begin() + at, ' ');
    return digits;
}

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

}  // namespace hexrelief::cli
