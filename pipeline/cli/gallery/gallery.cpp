#include "pipeline/cli/gallery/gallery.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "exporters/core/mesh_format.h"
#include "exporters/viewer/html_exporter.h"
#include "pipeline/data/error.h"
#include "pipeline/data/nesting.h"
#include "pipeline/files/output_set.h"
#include "pipeline/readers/image_reader.h"

namespace hexrelief::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double number(const Json& json, const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? found->get<double>() : kUnknown;
}

constexpr std::uintmax_t kLongestPage = std::uintmax_t{1} << 30;
constexpr std::size_t kLongestFacts = 16 << 20;  // of a page, which hold its pictures; and of a report

// Returns the text behind `before` up to `after`, or from the file's beginning if `before` is empty. Empty if
// the file holds no such text, or is larger than those of this program. A device has no bytes by its size.
std::string text_between(const fs::path& path, std::string_view before, std::string_view after) {
    std::error_code none;
    const std::uintmax_t size = fs::file_size(path, none);
    if (none || size > kLongestPage) return {};
    std::ifstream stream(path, std::ios::binary);
    std::string text, block(1 << 16, '\0');
    bool is_found = before.empty();
    for (std::uintmax_t left = size; left > 0;) {
        block.resize(static_cast<std::size_t>(std::min<std::uintmax_t>(left, block.size())));
        if (!stream.read(block.data(), static_cast<std::streamsize>(block.size()))) return {};
        left -= block.size();
        const std::size_t searched_from = is_found ? text.size() : 0;
        text += block;
        if (!is_found) {
            const std::size_t at = text.find(before);
            is_found = at != std::string::npos;
            text.erase(0, is_found ? at + before.size() : text.size() - std::min(text.size(), before.size()));
        }
        if (!is_found) continue;
        if (const std::size_t end = after.empty() ? std::string::npos : text.find(after, searched_from);
            end != std::string::npos)
            return text.substr(0, end);
        if (text.size() > kLongestFacts) return {};
    }
    return after.empty() ? text : std::string();
}

std::optional<Json> parsed(std::string_view text) {
    if (is_nested_too_deeply(text)) return std::nullopt;
    Json json = Json::parse(text, nullptr, false);
    if (!json.is_object()) return std::nullopt;
    return json;
}

double page_figure(const Json& facts, const char* name) {
    for (const Json& figure : facts.value("figures", Json::array()))
        if (figure.is_object() && figure.value("name", "") == name) return number(figure, "value");
    return kUnknown;
}

std::optional<FoundResult> read_page(const fs::path& path) {
    const auto facts = parsed(text_between(path, R"(id="facts">)", "<"));
    if (!facts || !facts->contains("levels") || !(*facts)["levels"].is_array() || (*facts)["levels"].empty())
        return std::nullopt;
    const Json& finest = (*facts)["levels"][0];
    FoundResult result{
        path,
        "",
        {number(finest, "vertices"), number(finest, "triangles"), static_cast<double>(fs::file_size(path)),
         page_figure(*facts, "%cost"), page_figure(*facts, "Error, both views"), kUnknown}};
    for (const Json& picture : facts->value("pictures", Json::array()))
        if (picture.is_object() && picture.value("name", "") == "relief")
            result.picture = picture.value("source", "");
    return result;
}

// Returns the file that a report names: beside the report, if all were moved together, or as it was named,
// relative to the current folder or, because the run's folder is unknown, to one of the folders above the
// report. Empty if there is none.
fs::path existing(const fs::path& named, const fs::path& report) {
    std::error_code none;
    const fs::path beside = report.parent_path() / named.filename();
    if (fs::is_regular_file(beside, none)) return beside;
    if (fs::is_regular_file(named, none)) return named;
    for (fs::path above = fs::absolute(report).parent_path(); above.has_relative_path();
         above = above.parent_path())
        if (fs::is_regular_file(above / named, none)) return above / named;
    return {};
}

// Returns the page that a report names, else its first mesh.
fs::path result_file(const Json& report, const fs::path& path) {
    fs::path first;
    for (const Json& output : report.value("outputs", Json::array())) {
        if (!output.is_object()) continue;
        const fs::path file = existing(output.value("path", ""), path);
        if (file.empty()) continue;
        if (exporters::extension_of(file) == ".html") return file;
        if (first.empty()) first = file;
    }
    return first;
}

// Returns the relief drawn by --save-stages, in the report's folder or in its folder `stages`. With several
// reports it is unknown to which of them it belongs.
std::string stage_picture(const fs::path& report) {
    std::error_code none;
    for (const char* name : {"stages/relief.png", "relief.png"}) {
        const fs::path file = report.parent_path() / name;
        if (!fs::is_regular_file(file, none)) continue;
        try {
            return exporters::small_picture(readers::read_image(file));
        } catch (const Error&) {  // another file of that name
        }
    }
    return {};
}

// Reads a report; returns nothing if it is not one, or its meshes are gone. The result has no picture.
std::optional<FoundResult> read_report(const fs::path& path) {
    const auto report = parsed(text_between(path, "", ""));
    if (!report || !report->contains("hexrelief") || !report->contains("surface") ||
        !report->contains("mesh"))
        return std::nullopt;
    const fs::path file = result_file(*report, path);
    if (file.empty()) return std::nullopt;
    std::error_code none;
    const Json &surface = (*report)["surface"], &mesh = (*report)["mesh"];
    return FoundResult{file,
                       "",
                       {number(surface, "vertices"), number(surface, "triangles"),
                        static_cast<double>(fs::file_size(file, none)), number(mesh, "percent_cost"),
                        number(surface, "duo_rmse_near_px"), number(*report, "seconds")}};
}

std::vector<fs::path> files_below(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code none;
    constexpr auto kSkip = fs::directory_options::skip_permission_denied;
    for (auto it = fs::recursive_directory_iterator(folder, kSkip, none);
         it != fs::recursive_directory_iterator(); it.increment(none))
        if (it->is_regular_file(none)) files.push_back(it->path());
    std::ranges::sort(files);
    return files;
}

// Returns nothing if the file's JSON is of another kind than this program writes.
template <typename Read>
std::optional<FoundResult> read_known(const Read& read, const fs::path& file) {
    try {
        return read(file);
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

const std::vector<exporters::GalleryColumn> kColumns = {{"Vertices", 0}, {"Triangles", 0}, {"Bytes", 0},
                                                        {"%cost", 2},    {"Error, px", 3}, {"Seconds", 2}};

exporters::GalleryEntry entry_of(FoundResult result, const fs::path& folder, const fs::path& place) {
    const auto& [vertices, triangles, bytes, percent_cost, error_px, seconds] = result.figures;
    fs::path name = fs::relative(result.file, folder);
    if (exporters::extension_of(name) == ".html") name.replace_extension();
    return {name.generic_string(),
            fs::relative(result.file, place),
            std::move(result.picture),
            {vertices, triangles, bytes, percent_cost, error_px, seconds}};
}

}  // namespace

std::vector<FoundResult> find_results(const fs::path& folder) {
    std::map<fs::path, FoundResult> results, reports;
    const std::vector<fs::path> files = files_below(folder);
    for (const fs::path& file : files)
        if (exporters::extension_of(file) == ".html")
            if (const auto page = read_known(read_page, file)) results[fs::weakly_canonical(file)] = *page;
    for (const fs::path& file : files) {
        if (exporters::extension_of(file) != ".json") continue;
        if (auto report = read_known(read_report, file)) reports[file] = std::move(*report);
    }
    std::map<fs::path, int> reports_in;
    for (const auto& [file, report] : reports) ++reports_in[file.parent_path()];
    for (auto& [file, report] : reports) {
        if (reports_in[file.parent_path()] == 1) report.picture = stage_picture(file);
        const auto [slot, is_new] = results.try_emplace(fs::weakly_canonical(report.file), report);
        if (!is_new) slot->second.figures.seconds = report.figures.seconds;
    }
    std::vector<FoundResult> out;
    for (auto& [path, result] : results) out.push_back(std::move(result));
    return out;
}

std::size_t write_gallery(const fs::path& folder, const fs::path& path) {
    if (!exporters::has_viewer())
        throw Error(ErrorKind::usage, std::string("no gallery can be made: ") + exporters::kNoViewer);
    if (!fs::is_directory(folder))
        throw Error(ErrorKind::input, "cannot read '" + folder.string() + "': it is no folder");
    if (exporters::extension_of(path) != ".html")
        throw Error(ErrorKind::usage, "'" + path.string() + "': a gallery is a page; name a file .html");
    files::check_writable_file(path);
    std::vector<exporters::GalleryEntry> entries;
    for (FoundResult& result : find_results(folder)) {
        files::check_overwrites({path}, {result.file});
        entries.push_back(entry_of(std::move(result), folder, fs::absolute(path).parent_path()));
    }
    if (entries.empty())
        throw Error(ErrorKind::input, "'" + folder.string() +
                                          "' holds no result; hexrelief run -o a.html --report a.json "
                                          "writes what a gallery shows");
    const std::string title = fs::canonical(folder).filename().string();
    files::OutputSet outputs;
    outputs.write(path, exporters::gallery_page(title, kColumns, entries));
    outputs.commit();
    return entries.size();
}

}  // namespace hexrelief::cli
