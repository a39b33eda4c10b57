#include "pipeline/tiles/tile_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "pipeline/data/error.h"
#include "pipeline/stages/surface.h"
#include "pipeline/stages/surface_topology.h"

namespace hexrelief::tiles {
namespace {

constexpr std::int64_t kMostSteps = 1 << 24;  // that a float holds exactly

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
    if (std::none_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
            return std::all_of(t.begin(), t.end(),
                               [&](std::uint32_t v) { return can_be_placed(mesh.corners[v]); });
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

void drop_specks(mesh_tiles::TileMesh& mesh, int min_triangles) {
    if (min_triangles <= 1 || mesh.empty()) return;
    // Union-find over the corners' numbers: each corner points to one before it or to itself.
    std::vector<std::uint32_t> parents(mesh.corners.size());
    for (std::uint32_t v = 0; v < parents.size(); ++v) parents[v] = v;
    const auto root = [&](std::uint32_t v) {
        while (parents[v] != v) v = parents[v] = parents[parents[v]];
        return v;
    };
    for (const Triangle& t : mesh.triangles)
        for (int k = 1; k < 3; ++k) {
            const std::uint32_t a = root(t[0]), b = root(t[static_cast<std::size_t>(k)]);
            parents[std::max(a, b)] = std::min(a, b);
        }
    std::vector<int> triangles(mesh.corners.size(), 0);
    for (const Triangle& t : mesh.triangles) ++triangles[root(t[0])];
    std::set<mesh_tiles::TileCorner> at_seams;
    for (const auto& edge : mesh.seam_edges) at_seams.insert(edge.begin(), edge.end());
    std::vector<bool> stays(mesh.corners.size());
    for (std::uint32_t v = 0; v < parents.size(); ++v)
        if (triangles[root(v)] >= min_triangles || at_seams.contains(mesh.corners[v])) stays[root(v)] = true;
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return !stays[root(t[0])]; });
}

}  // namespace hexrelief::tiles
