#include "pipeline/tiles/tile_report.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/data/error.h"
#include "pipeline/data/nesting.h"

namespace hexrelief::tiles {

using Json = nlohmann::ordered_json;

std::string report_text(const TileReport& report) {
    Json json;
    json["plan"] = report.plan;
    json["vertices"] = report.vertices;
    json["triangles"] = report.triangles;
    json["seam_edges"] = report.seam_edges;
    json["low_m"] = report.low_m;
    json["high_m"] = report.high_m;
    json["error_px"] = report.error_px;
    json["error_m"] = report.error_m;
    json["files"] = Json::array();
    for (const files::WrittenFile& file : report.files)
        json["files"].push_back(
            {{"name", file.path.string()}, {"bytes", file.bytes}, {"sha256", file.sha256}});
    return json.dump(2) + "\n";
}

TileReport read_tile_report(const std::filesystem::path& path) {
    // The size comes first: a pipe has none, and would be waited for.
    constexpr std::uintmax_t longest = 16 << 20;
    std::error_code code;
    const bool is_file = std::filesystem::is_regular_file(path, code);
    std::ifstream file(is_file ? path : std::filesystem::path(), std::ios::binary);
    if (!file) throw Error(ErrorKind::input, path.string() + ": is missing; run 'hexrelief tiles solve'");
    std::string text(std::min(std::filesystem::file_size(path), longest), ' ');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    try {
        const Json json = is_nested_too_deeply(text) ? Json() : Json::parse(text);
        TileReport report;
        report.plan = json.at("plan");
        report.vertices = json.at("vertices");
        report.triangles = json.at("triangles");
        report.seam_edges = json.at("seam_edges");
        report.low_m = json.at("low_m");
        report.high_m = json.at("high_m");
        report.error_px = json.at("error_px");
        report.error_m = json.at("error_m");
        for (const Json& one : json.at("files"))
            report.files.push_back({one.at("name").get<std::string>(), one.at("bytes"), one.at("sha256")});
        return report;
    } catch (const Json::exception&) {
        throw Error(ErrorKind::input,
                    path.string() + ": is damaged; remove it and run 'hexrelief tiles solve'");
    }
}

}  // namespace hexrelief::tiles
