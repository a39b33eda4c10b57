#include "pipeline/stamp/stamp.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "pipeline/config/document.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
#include "pipeline/files/sha256.h"

namespace hexrelief {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// With what the configuration does not tell: that a key was given, even with its default (a budget does not
// change what was given).
std::string config_text(const Config& config) {
    Json json = config_json(config);
    json["run"].erase("threads");
    json["run"].erase("backend");
    json.erase("limits");                        // they change no byte
    json["input"]["calibration"].erase("file");  // its bytes are hashed
    std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    for (const std::string& path : config.given)
        if (path != "run.threads" && path != "run.backend" && !path.starts_with("limits."))
            text += "\ngiven " + path;
    return text;
}

std::string digest_line(const char* role, const fs::path& path) {
    return path.empty() ? "" : std::string(role) + " " + sha256_of_file(path) + "\n";
}

// An output that the report tells of: beside the report, where the folder was moved, or where it was written.
bool is_as_written(const Json& output, const fs::path& report) {
    const fs::path told = output.at("path").get<std::string>();
    std::error_code code;
    fs::path file = report.parent_path() / told.filename();
    if (!fs::is_regular_file(file, code)) file = told;
    return fs::file_size(file, code) == output.at("bytes").get<std::uintmax_t>() && !code &&
           sha256_of_file(file) == output.at("sha256").get<std::string>();
}

bool are_as_written(const RunRequest& request, const Json& outputs) {
    std::set<fs::path> names;
    for (const Json& output : outputs) {
        if (!is_as_written(output, request.report)) return false;
        names.insert(fs::path(output.at("path").get<std::string>()).filename());
    }
    std::error_code code;
    const bool all_named = std::all_of(request.outputs.begin(), request.outputs.end(),
                                       [&](const fs::path& file) { return names.contains(file.filename()); });
    return all_named && (request.depfile.empty() || fs::exists(request.depfile, code)) &&
           (request.stages_folder.empty() || fs::is_directory(request.stages_folder, code));
}

}  // namespace

std::string unit_stamp(const RunRequest& request) {
    std::string text =
        std::string("hexrelief ") + HEXRELIEF_VERSION + "\n" + config_text(request.config) + "\n";
    for (const fs::path& output : request.outputs) text += "output " + output.filename().string() + "\n";
    if (!request.stages_folder.empty()) text += "stages\n";
    text += digest_line("left", request.left) + digest_line("right", request.right) +
            digest_line("stereo", request.stereo) + digest_line("disparity", request.disparity) +
            digest_line("depth", request.depth) + digest_line("color", request.color) +
            digest_line("mask", request.mask) + digest_line("confidence", request.confidence) +
            digest_line("calibration", request.config.input.calibration.file);
    return sha256_of(text.data(), text.size());
}

UnitState stamp_request(RunRequest& request) {
    if (request.report.empty() || is_standard_output(request.report)) return UnitState::missing;
    request.stamp = unit_stamp(request);
    return unit_state(request, request.stamp);
}

UnitState unit_state(const RunRequest& request, const std::string& stamp) {
    std::ifstream file(request.report, std::ios::binary);
    const Json report = Json::parse(file, nullptr, false);
    if (!report.is_object() || !report.contains("stamp")) return UnitState::missing;
    if (report["stamp"] != stamp) return UnitState::changed;
    try {
        return are_as_written(request, report.at("outputs")) ? UnitState::current : UnitState::changed;
    } catch (const Json::exception&) {  // a report that was edited
        return UnitState::changed;
    } catch (const Error&) {  // an output that cannot be read
        return UnitState::changed;
    }
}

}  // namespace hexrelief
