#include "pipeline/tiles/tile_output.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>

#include "exporters/exporter.h"
#include "pipeline/data/error.h"
#include "pipeline/data/union_find.h"
#include "pipeline/files/sha256.h"
#include "pipeline/job/stamp/stamp.h"
#include "pipeline/stages/join_crumbs.h"
#include "pipeline/stages/surface.h"
#include "pipeline/tiles/tile_files.h"

namespace hexrelief::tiles {
namespace {

constexpr std::int64_t kMostSteps = 1 << 24;  // that a float holds exactly

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using GridPoint = std::array<std::int64_t, 3>;

GridPoint grid_point(const TilePlan& plan, const mesh_tiles::TileCorner& corner) {
    const std::array<double, 3> p = stages::position_in_space(
        double(corner.place.x) / mesh_tiles::kPlacesPerPixel,
        double(corner.place.y) / mesh_tiles::kPlacesPerPixel, corner.disparity, plan.calibration);
    GridPoint point;
    for (std::size_t k = 0; k < 3; ++k) point[k] = std::llround(p[k] / plan.grid_step_m);
    return point;
}

DisparityMesh in_picture(const mesh_tiles::TileMesh& mesh, const mesh_tiles::MapRect& window) {
    DisparityMesh seen;
    seen.points.reserve(mesh.corners.size());
    seen.disparities.reserve(mesh.corners.size());
    for (const mesh_tiles::TileCorner& corner : mesh.corners) {
        seen.points.push_back(mesh_tiles::in_window(corner.place, window));
        seen.disparities.push_back(corner.disparity);
    }
    seen.triangles = mesh.triangles;
    return seen;
}

// Returns the corners on edges that the tile shares with others.
std::vector<std::uint32_t> at_seams(const mesh_tiles::TileMesh& mesh) {
    std::set<mesh_tiles::TileCorner> shared;
    for (const auto& edge : mesh.seam_edges) shared.insert(edge.begin(), edge.end());
    std::vector<std::uint32_t> found;
    for (std::uint32_t v = 0; v < mesh.corners.size(); ++v)
        if (shared.contains(mesh.corners[v])) found.push_back(v);
    return found;
}

}  // namespace

TileScene tile_scene(const TilePlan& plan, const mesh_tiles::TileMesh& mesh,
                     const mesh_tiles::MapRect& window) {
    Calibration camera = plan.calibration;
    camera.cx -= window.x;
    camera.cy -= window.y;
    TileScene scene;
    const auto can_be_placed = [&](const mesh_tiles::TileCorner& corner) {
        return corner.disparity + camera.doffs_px > 0;
    };
    if (std::ranges::none_of(mesh.triangles, [&](const Triangle& t) {
            return std::ranges::all_of(t, [&](std::uint32_t v) { return can_be_placed(mesh.corners[v]); });
        }))
        return scene;
    std::vector<std::uint32_t> corners;
    scene.mesh =
        stages::build_surface(in_picture(mesh, window), window.width, window.height, camera, 0, &corners);
    std::vector<GridPoint> points;
    points.reserve(corners.size());
    for (const std::uint32_t corner : corners) points.push_back(grid_point(plan, mesh.corners[corner]));
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [least, most] = std::minmax_element(
            points.begin(), points.end(), [k](const auto& a, const auto& b) { return a[k] < b[k]; });
        const std::int64_t low = (*least)[k], high = (*most)[k], origin = low + (high - low) / 2;
        if (high - low >= kMostSteps)
            throw Error(ErrorKind::input, "a tile is " + std::to_string(high - low) +
                                              " steps of the grid long; raise export.tolerance_px or "
                                              "density.background, and make the plan again");
        scene.origin_m[k] = static_cast<double>(origin) * plan.grid_step_m;
        scene.low_m[k] = static_cast<double>(low) * plan.grid_step_m;
        scene.high_m[k] = static_cast<double>(high) * plan.grid_step_m;
        for (std::size_t v = 0; v < points.size(); ++v) {
            Vec3f& p = scene.mesh.positions[v];
            (k == 0   ? p.x
             : k == 1 ? p.y
                      : p.z) =
                static_cast<float>(static_cast<double>(points[v][k] - origin) * plan.grid_step_m);
        }
    }
    return scene;
}

void join_crumbs(mesh_tiles::TileMesh& mesh, const mesh_tiles::MapRect& window, double cell_px) {
    DisparityMesh seen = in_picture(mesh, window);
    stages::join_crumbs(seen, cell_px, 0, at_seams(mesh));
    mesh.triangles = std::move(seen.triangles);
}

void drop_specks(mesh_tiles::TileMesh& mesh, int min_triangles) {
    if (min_triangles <= 1 || mesh.empty()) return;
    UnionFind parts(mesh.corners.size());
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t corner : t) parts.join(t[0], corner);
    std::vector<int> triangles(mesh.corners.size(), 0);
    for (const Triangle& t : mesh.triangles) ++triangles[parts.find(t[0])];
    std::vector<bool> stays(mesh.corners.size());
    for (std::uint32_t v = 0; v < mesh.corners.size(); ++v)
        if (triangles[parts.find(v)] >= min_triangles) stays[parts.find(v)] = true;
    for (const std::uint32_t v : at_seams(mesh)) stays[parts.find(v)] = true;
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return !stays[parts.find(t[0])]; });
}

namespace {

// Calls use(key, member) for each figure of a report.
template <typename Report, typename Use>
void for_each_figure(Report& report, const Use& use) {
    use("plan", report.plan);
    use("vertices", report.vertices);
    use("triangles", report.triangles);
    use("seam_edges", report.seam_edges);
    use("low_m", report.low_m);
    use("high_m", report.high_m);
    use("error_px", report.error_px);
    use("error_m", report.error_m);
}

std::string report_text(const TileReport& report) {
    Json json;
    for_each_figure(report, [&](const char* key, const auto& value) { json[key] = value; });
    json["files"] = Json::array();
    for (const files::WrittenFile& file : report.files)
        json["files"].push_back(
            {{"name", file.path.string()}, {"bytes", file.bytes}, {"sha256", file.sha256}});
    return json.dump(2) + "\n";
}

}  // namespace

TileReport read_tile_report(const fs::path& path) {
    std::error_code none;
    if (!fs::is_regular_file(path, none))
        throw Error(ErrorKind::input, path.string() + ": is missing; run 'hexrelief tiles solve'");
    try {
        const Json json = job::read_json(path);
        TileReport report;
        for_each_figure(report, [&](const char* key, auto& value) { json.at(key).get_to(value); });
        for (const Json& one : json.at("files"))
            report.files.push_back({one.at("name").get<std::string>(), one.at("bytes"), one.at("sha256")});
        return report;
    } catch (const Json::exception&) {
        throw Error(ErrorKind::input,
                    path.string() + ": is damaged; remove it and run 'hexrelief tiles solve'");
    }
}

void write_tile(const TilePlan& plan, const TileNumber& tile, const mesh_tiles::TileMesh& mesh,
                const TileScene& scene, const Image* texture, int threads, TileReport report) {
    files::OutputSet files;
    const auto place = [&](const char* extension) {
        const fs::path path = tile_file(plan, tile, extension);
        std::error_code none;
        if (fs::exists(path, none) && !fs::is_regular_file(path, none))
            throw Error(ErrorKind::output, path.string() + ": is no regular file; remove it");
        files.place(path);
        return path;
    };
    files.files().write(place(".mesh"), tile_bytes(mesh));
    if (!scene.mesh.empty()) {
        exporters::Scene exported{
            &scene.mesh, texture, std::string("hexrelief ") + HEXRELIEF_VERSION, {}, nullptr};
        exported.threads = threads;
        exported.grid_step_m = plan.grid_step_m;
        exported.origin_m = scene.origin_m;
        exporters::export_scene(exported, plan.config.exporting, place(".glb"), files.files());
    }
    report.plan = plan.stamp;
    report.vertices = scene.mesh.positions.size();
    report.triangles = scene.mesh.triangles.size();
    report.seam_edges = mesh.seam_edges.size();
    report.low_m = scene.low_m;
    report.high_m = scene.high_m;
    report.files = files.written();
    for (files::WrittenFile& file : report.files) file.path = file.path.lexically_relative(plan.folder);
    files.files().write(place(".json"), report_text(report));
    files.commit();
}

bool is_solved(const TilePlan& plan, const TileNumber& tile) {
    const fs::path path = tile_file(plan, tile, ".json");
    std::error_code none;
    if (!fs::is_regular_file(path, none)) return false;
    try {
        const TileReport report = read_tile_report(path);
        return report.plan == plan.stamp &&
               std::ranges::all_of(report.files, [&](const files::WrittenFile& file) {
                   const fs::path name = plan.folder / file.path;
                   return fs::is_regular_file(name) && fs::file_size(name) == file.bytes &&
                          files::sha256_of_file(name) == file.sha256;
               });
    } catch (const Error&) {
        return false;
    }
}

}  // namespace hexrelief::tiles
