#include "pipeline/tiles/tile_plan.h"

#include <sys/stat.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "mesher/som/level_plan.h"
#include "pipeline/config/document.h"
#include "pipeline/config/reader.h"
#include "pipeline/data/error.h"
#include "pipeline/files/sha256.h"
#include "pipeline/job/report.h"
#include "pipeline/job/stamp/stamp.h"

namespace hexrelief::tiles {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// To be increased when plans change: older plans' tiles are not those that this program would make.
constexpr int kPlanVersion = 1;

std::string numbered(const char* format, int a, int b) {
    char text[64];
    std::snprintf(text, sizeof text, format, a, b);
    return text;
}

[[noreturn]] void refuse_plan(const fs::path& path, const char* why) {
    throw Error(ErrorKind::input, path.string() + ": " + why + "; run 'hexrelief tiles plan' again");
}

Json file_json(const PlannedFile& file) {
    return {{"path", file.path.string()}, {"bytes", file.bytes}, {"modified_ns", file.modified_ns}};
}

PlannedFile file_of(const Json& json) {
    return {json.at("path").get<std::string>(), json.at("bytes"), json.at("modified_ns")};
}

Json raw_json(const readers::RawMapLayout& raw) {
    return {{"width", raw.width},
            {"height", raw.height},
            {"sample", raw.sample == readers::MapSample::uint16 ? "uint16" : "float32"},
            {"big_endian", raw.is_big_endian}};
}

readers::RawMapLayout raw_of(const Json& json) {
    return {json.at("width"), json.at("height"),
            json.at("sample") == "uint16" ? readers::MapSample::uint16 : readers::MapSample::float32,
            json.at("big_endian")};
}

Calibration camera_of(const Json& json) {
    return {.focal_px = json.at("focal_px"),
            .cx = json.at("cx"),
            .cy = json.at("cy"),
            .baseline_m = json.at("baseline_m"),
            .doffs_px = json.at("doffs_px"),
            .metric = json.at("metric")};
}

Json plan_json(const TilePlan& plan) {
    Json json = {{"hexrelief", {{"plan", kPlanVersion}, {"version", HEXRELIEF_VERSION}}},
                 {"map", file_json(plan.map)}};
    if (plan.raw) json["map"]["raw"] = raw_json(*plan.raw);
    json["map"]["width"] = plan.width;
    json["map"]["height"] = plan.height;
    json["map"]["nearest_px"] = plan.nearest_px;
    json["map"]["farthest_px"] = plan.farthest_px;
    if (!plan.color.path.empty()) json["color"] = file_json(plan.color);
    json["calibration"] = job::calibration_json(plan.calibration);
    const mesh_tiles::LatticeTiling tiling = plan.tiling();
    json["lattice"] = {{"columns", plan.columns},
                       {"rows", plan.rows},
                       {"tile_spacings", plan.tile_spacings},
                       {"tiles_across", tiling.across()},
                       {"tiles_down", tiling.down()},
                       {"shrunk_by", plan.shrunk_by}};
    json["density"] = {{"scale_px", plan.density.scale_px}, {"background_px", plan.density.background_px}};
    json["grid_step_m"] = plan.grid_step_m;
    return json;
}

// Returns an integer within its range. Throws Json::exception if it is none.
int integer(const Json& json, const char* key, int least, int most) {
    const Json& value = json.at(key);
    const auto number = value.is_number_integer() ? value.get<std::int64_t>() : std::int64_t{least} - 1;
    if (number < least || number > most)
        throw Json::other_error::create(501, std::string(key) + " is out of range", &json);
    return static_cast<int>(number);
}

// True if the plan's numbers, each in its range, agree with each other as plan_tiles() leaves them.
bool is_consistent(const TilePlan& plan) {
    const auto lattice = som::lattice_size(plan.width, plan.height, plan.config.mesh.spacing_px);
    const Calibration& camera = plan.calibration;
    const auto is_positive = [](double value) { return std::isfinite(value) && value > 0; };
    return plan.columns == lattice.columns && plan.rows == lattice.rows &&
           std::has_single_bit(static_cast<unsigned>(plan.shrunk_by)) &&
           plan.shrunk_by <= std::min(plan.width, plan.height) && is_positive(camera.focal_px) &&
           is_positive(camera.baseline_m) && std::isfinite(camera.doffs_px) && std::isfinite(camera.cx) &&
           std::isfinite(camera.cy) && is_positive(plan.density.scale_px) &&
           std::isfinite(plan.density.background_px) && is_positive(plan.grid_step_m) &&
           std::isfinite(plan.nearest_px) && plan.nearest_px >= plan.farthest_px;
}

TilePlan plan_of(const Json& json) {
    TilePlan plan;
    const Json& map = json.at("map");
    plan.map = file_of(map);
    if (map.contains("raw")) plan.raw = raw_of(map.at("raw"));
    plan.width = integer(map, "width", 1, kLargestTiledSide_px);
    plan.height = integer(map, "height", 1, kLargestTiledSide_px);
    plan.nearest_px = map.at("nearest_px");
    plan.farthest_px = map.at("farthest_px");
    if (json.contains("color")) plan.color = file_of(json.at("color"));
    plan.calibration = camera_of(json.at("calibration"));
    const Json& lattice = json.at("lattice");
    plan.columns = integer(lattice, "columns", 3, kLargestTiledSide_px);
    plan.rows = integer(lattice, "rows", 3, kLargestTiledSide_px);
    plan.tile_spacings = integer(lattice, "tile_spacings", 1, kLargestTiledSide_px);
    plan.shrunk_by = integer(lattice, "shrunk_by", 1, kLargestTiledSide_px);
    plan.density = {json.at("density").at("scale_px"), json.at("density").at("background_px")};
    plan.grid_step_m = json.at("grid_step_m");
    return plan;
}

void check_unchanged(const PlannedFile& file) {
    if (!file.path.empty() && planned_file(file.path) != file)
        refuse_plan(file.path, "it has changed since the plan was made");
}

}  // namespace

PlannedFile planned_file(const fs::path& path) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode))
        throw Error(ErrorKind::input, path.string() + ": there is no such file");
    return {fs::absolute(path).lexically_normal(), static_cast<std::uint64_t>(status.st_size),
            std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

fs::path plan_file(const fs::path& folder) {
    return folder / "plan.json";
}

fs::path plan_config_file(const fs::path& folder) {
    return folder / "config.yaml";
}

fs::path coarse_file(const TilePlan& plan) {
    return plan.folder / "coarse.lattice";
}

fs::path row_seam_file(const TilePlan& plan, int j) {
    return plan.folder / "seams" / numbered("row-%04d.lattice", j, 0);
}

fs::path column_seam_file(const TilePlan& plan, int i, int j) {
    return plan.folder / "seams" / numbered("column-%04d-%04d.lattice", j, i);
}

fs::path tile_file(const TilePlan& plan, const TileNumber& tile, const std::string& extension) {
    return plan.folder / "tiles" / std::to_string(tile.level) / std::to_string(tile.i) /
           (std::to_string(tile.j) + extension);
}

int TilePlan::finest_level() const {
    const mesh_tiles::LatticeTiling all = tiling();
    int level = 0;
    while ((1 << level) < std::max(all.across(), all.down())) ++level;
    return level;
}

std::vector<TileNumber> tiles_of_level(const TilePlan& plan, int level) {
    const mesh_tiles::LatticeTiling all = plan.tiling();
    const int by = 1 << (plan.finest_level() - level);
    std::vector<TileNumber> tiles;
    for (int j = 0; j * by < all.down(); ++j)
        for (int i = 0; i * by < all.across(); ++i) tiles.push_back({level, i, j});
    return tiles;
}

std::vector<TileNumber> children_of(const TilePlan& plan, const TileNumber& tile) {
    const mesh_tiles::LatticeTiling all = plan.tiling();
    const int level = tile.level + 1, by = 1 << (plan.finest_level() - level);
    std::vector<TileNumber> children;
    for (int j = 2 * tile.j; j <= 2 * tile.j + 1 && j * by < all.down(); ++j)
        for (int i = 2 * tile.i; i <= 2 * tile.i + 1 && i * by < all.across(); ++i)
            children.push_back({level, i, j});
    return children;
}

std::string tile_name(const TilePlan& plan, const TileNumber& tile) {
    const std::string name = "(" + std::to_string(tile.j) + ", " + std::to_string(tile.i) + ")";
    return tile.level == plan.finest_level() ? name : name + " of level " + std::to_string(tile.level);
}

void write_plan(TilePlan& plan, files::OutputSet& files) {
    config::Config kept = plan.config;
    // The tiles do not depend on backend and threads: a plan made with others has the same stamp.
    kept.run.backend = config::ExecutionConfig{}.backend;
    kept.run.threads = config::ExecutionConfig{}.threads;
    files.write(plan_config_file(plan.folder), config::config_yaml(kept));
    Json json = plan_json(plan);
    for (const files::WrittenFile& file : files.written())
        plan.sums[file.path.lexically_relative(plan.folder).string()] = file.sha256;
    for (const auto& [name, sum] : plan.sums) json["files"][name] = sum;
    std::string text;
    try {
        text = json.dump(2) + "\n";
    } catch (const Json::exception&) {
        throw Error(
            ErrorKind::input,
            plan.map.path.string() + ": a plan holds names in UTF-8 only; rename the map or the picture");
    }
    plan.stamp = files::sha256_of(text.data(), text.size());
    files.write(plan_file(plan.folder), text);
}

TilePlan read_plan(const fs::path& folder) {
    const fs::path path = plan_file(folder);
    if (!fs::is_regular_file(path)) refuse_plan(folder, "holds no plan.json");
    const Json json = job::read_json(path);
    TilePlan plan;
    try {
        if (json.at("hexrelief").at("plan") != kPlanVersion ||
            json.at("hexrelief").at("version") != HEXRELIEF_VERSION)
            refuse_plan(path, "made by another version of hexrelief");
        plan = plan_of(json);
        for (const auto& [name, sum] : json.at("files").items()) plan.sums[name] = sum;
    } catch (const Json::exception&) {
        refuse_plan(path, "damaged");
    }
    plan.folder = folder;
    plan.stamp = files::sha256_of_file(path);
    check_planned_file(plan, plan_config_file(folder));
    config::apply_config_file(plan.config, plan_config_file(folder));
    if (!is_consistent(plan)) refuse_plan(path, "damaged: its numbers do not agree");
    check_unchanged(plan.map);
    check_unchanged(plan.color);
    return plan;
}

void check_planned_file(const TilePlan& plan, const fs::path& path) {
    const auto sum = plan.sums.find(path.lexically_relative(plan.folder).string());
    if (sum == plan.sums.end() || !fs::is_regular_file(path) || files::sha256_of_file(path) != sum->second)
        refuse_plan(path, "is not as the plan left it");
}

}  // namespace hexrelief::tiles
