#include "pipeline/cli/summary.h"

#include <algorithm>
#include <cstdio>

#include "exporters/core/file_names.h"

namespace hexrelief {
namespace {

template <typename... Values>
std::string text(const char* format, Values... values) {
    char buffer[256];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

std::string budget_line(const BudgetResult& budget) {
    return text("budget %s %.6g: reached %.6g at a spacing of %.6g px, tolerance %.6g px, in %d solves\n",
                budget.kind.c_str(), budget.limit, budget.reached, budget.spacing_px, budget.tolerance_px,
                budget.solves);
}

std::string files_line(const RunReport& report, const RunRequest& request) {
    std::string line;
    const auto add = [&](const std::string& file) { line += (line.empty() ? "" : ", ") + file; };
    for (const OutputFile& file : report.outputs) add(file.path + " " + grouped(file.bytes) + " bytes");
    if (!request.report.empty()) add("report " + request.report.string());
    if (!request.stages_folder.empty()) add("stages in " + request.stages_folder.string());
    return line + "\n";
}

// Only shares that are not printed as 0.
std::string shares_text(const PictureShares& shares) {
    std::string line = text("%.1f %% of the picture is meshed", 100 * shares.meshed);
    const auto add = [&](const char* name, double share) {
        if (share >= 0.0005) line += text(", %.1f %% is %s", 100 * share, name);
    };
    add("background", shares.background);
    add("unknown", shares.unknown);
    add("occluded", shares.occluded);
    return line;
}

bool lacks_color(const RunRequest& request) {
    return request.left.empty() && request.stereo.empty() && request.color.empty() &&
           request.config.exporting.texture != TextureFormat::none &&
           std::any_of(request.outputs.begin(), request.outputs.end(), [](const std::filesystem::path& path) {
               return export_format(path) != MeshFormat::drc;
           });
}

}  // namespace

std::string grouped(std::uint64_t value) {
    std::string digits = std::to_string(value);
    for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3)
        digits.insert(digits.begin() + at, ' ');
    return digits;
}

std::string summary_of(const RunReport& report, const RunRequest& request, double seconds) {
    std::string summary = report.budget.kind.empty() ? "" : budget_line(report.budget);
    summary += files_line(report, request);
    summary += grouped(report.vertices) + " vertices, " + grouped(report.triangles) + " triangles";
    if (lacks_color(request)) summary += " without colours (--color gives some)";
    summary += text(", depth %.3g to %.3g%s; ", report.nearest(), report.farthest(),
                    report.calibration.metric ? " m" : " (relative)");
    summary += shares_text(report.shares);
    if (report.filling)
        summary += text("; %.1f %% was measured, %.1f %% filled between",
                        100 * report.filling->measured_share, 100 * report.filling->filled_share);
    summary += "; " + report.backend;
    if (report.device_bytes > 0) summary += " (" + grouped(report.device_bytes >> 10) + " KiB)";
    return summary + text(", %.2f s\n", seconds);
}

}  // namespace hexrelief
