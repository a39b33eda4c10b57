#include "pipeline/job/stamp/stamp.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "pipeline/config/document.h"
#include "pipeline/config/fields.h"
#include "pipeline/config/options.h"
#include "pipeline/data/error.h"
#include "pipeline/data/nesting.h"
#include "pipeline/files/output_set.h"
#include "pipeline/files/sha256.h"
#include "pipeline/job/run_files.h"
#include "pipeline/readers/source.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Erases "section.inner.leaf".
void erase(Json& json, const std::string& path) {
    std::string pointer = "/" + config::section_of(path);
    std::ranges::replace(pointer, '.', '/');
    json.at(Json::json_pointer(pointer)).erase(path.substr(path.rfind('.') + 1));
}

// Returns the configuration as text, with the keys that were given, since a key may be given with its default
// value (a budget does not change a given key).
std::string config_text(const config::Config& config) {
    Json json = config::config_json(config);
    json["run"].erase("threads");
    json["run"].erase("backend");
    json.erase("limits");  // the limits change no byte
    // The files' bytes are hashed, not their names.
    for (const config::Field& field : config::config_fields())
        if (field.type == config::FieldType::file) erase(json, field.path);
    std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    for (const std::string& path : config.given)
        if (path != "run.threads" && path != "run.backend" && !path.starts_with("limits."))
            text += "\ngiven " + path;
    return text;
}

std::string digest_line(const std::string& role, const fs::path& path) {
    static_cast<void>(readers::codec::load_head(path, 0));  // refuses as the run would
    return role + " " + files::sha256_of_file(path) + "\n";
}

bool is_as_written(const Json& output, const fs::path& file) {
    std::error_code code;
    return fs::file_size(file, code) == output.at("bytes").get<std::uintmax_t>() && !code &&
           files::sha256_of_file(file) == output.at("sha256").get<std::string>();
}

// The different paths of each file name, in order.
using PathsByName = std::map<fs::path, std::vector<fs::path>>;

// Returns the path's number among those of the same name; adds it if it is new. Two outputs
// may share a texture.
std::size_t number_of(const fs::path& path, PathsByName& paths) {
    std::vector<fs::path>& same_name = paths[path.filename()];
    const auto known = std::ranges::find(same_name, path);
    const auto number = static_cast<std::size_t>(known - same_name.begin());
    if (known == same_name.end()) same_name.push_back(path);
    return number;
}

// True if the report's files are in place. The report may name other folders than the request, because
// folders can be moved with their contents: the first file of a name must be where the request has its first
// file of that name, and so on.
bool are_as_written(const RunRequest& request, const Json& outputs) {
    PathsByName planned, told;
    for (const fs::path& output : request.outputs)
        for (const fs::path& file : planned_files(output, request.config.exporting)) number_of(file, planned);
    std::set<fs::path> found;
    for (const Json& output : outputs) {
        const fs::path path = output.at("path").get<std::string>();
        const std::size_t number = number_of(path, told);
        const std::vector<fs::path>& places = planned[path.filename()];
        if (number >= places.size() || !is_as_written(output, places[number])) return false;
        found.insert(places[number]);
    }
    // The report does not list the other files, whose bytes are not known.
    RunRequest others = request;
    others.outputs.clear();
    const std::vector<WrittenFile> unhashed = written_files(others);
    std::error_code code;
    return std::ranges::all_of(request.outputs, [&](const fs::path& file) { return found.contains(file); }) &&
           std::ranges::all_of(unhashed, [&](const WrittenFile& file) {
               return file.is_rectified || fs::exists(file.path, code);
           });
}

}  // namespace

std::string unit_stamp(const RunRequest& request) {
    std::string text =
        std::string("hexrelief ") + HEXRELIEF_VERSION + "\n" + config_text(request.config) + "\n";
    for (const fs::path& output : request.outputs) text += "output " + output.filename().string() + "\n";
    if (!request.stages_folder.empty()) text += "stages\n";
    for (const InputFile& file : input_files(request)) text += digest_line(file.role, file.path);
    // A program that matches pairs, its scripts and models, as far as its words name them.
    for (const std::string& words : {request.config.disparity.command, request.config.disparity.worker})
        for (const std::string& word : config::words_of_line(words)) {
            std::error_code code;
            if (fs::is_regular_file(word, code)) text += "program " + files::sha256_of_file(word) + "\n";
        }
    return files::sha256_of(text.data(), text.size());
}

nlohmann::ordered_json read_json(const fs::path& path) {
    constexpr std::uintmax_t most_bytes = 64 << 20;
    try {
        const std::vector<std::uint8_t> text = readers::codec::load_file(path, most_bytes).bytes;
        if (is_nested_too_deeply({reinterpret_cast<const char*>(text.data()), text.size()})) return nullptr;
        Json report = Json::parse(text, nullptr, false);
        return report.is_object() ? report : Json(nullptr);
    } catch (const Error&) {
        return nullptr;
    }
}

UnitState stamp_request(RunRequest& request) {
    if (request.report.empty() || files::is_standard_output(request.report)) return UnitState::missing;
    request.stamp = unit_stamp(request);
    return unit_state(request, request.stamp);
}

UnitState unit_state(const RunRequest& request, const std::string& stamp) {
    const Json report = read_json(request.report);
    if (report.is_null() || !report.contains("stamp")) return UnitState::missing;
    if (report["stamp"] != stamp) return UnitState::changed;
    try {
        return are_as_written(request, report.at("outputs")) ? UnitState::current : UnitState::changed;
    } catch (const Json::exception&) {  // a report that was edited
        return UnitState::changed;
    } catch (const Error&) {  // an output that cannot be read
        return UnitState::changed;
    }
}

}  // namespace hexrelief::job
