#include "mesher/open_sheet.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "mesher/align.h"
#include "mesher/pixel_surfaces.h"
#include "mesher/sheet_parts.h"
#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

constexpr int kRounds = 4;           // of splitting triangles that are still mixed
constexpr double kNeedle_px2 = 1.5;  // of the image

void check(const SheetInput& input) {
    const HexMesh2D& mesh = *input.mesh;
    const std::size_t count = static_cast<std::size_t>(mesh.columns) * mesh.rows;
    if (mesh.positions.size() != count)
        throw Error(ErrorKind::input, "surface: the mesh has " + std::to_string(count) +
                                          " lattice vertices, but " + std::to_string(mesh.positions.size()) +
                                          " positions");
    const DisparityMap& map = *input.map;
    if (map.width < 1 || map.height < 1 ||
        map.values.size() != static_cast<std::size_t>(map.width) * map.height)
        throw Error(ErrorKind::input,
                    "surface: the disparity map is empty; give the map that the mesh was made from");
    if (input.color && (input.color->width != map.width || input.color->height != map.height))
        throw Error(ErrorKind::input, "surface: the colour image's size is not the disparity map's");
}

// Whether a small triangle spans a step that its surface does not have: it rises by more than a jump, and so
// steeply that the two cameras could not both see it. In space it is a needle that sticks out. Larger ones
// stay: the holes that they would leave cost more than they do (duo_rmse_near_px of teddy without them 0.41
// -> 1.05, of cones 0.40 -> 0.55; with the limit 0.41 and 0.40).
bool is_needle(const SheetMesh& sheet, const Triangle& t, double jump_px) {
    const Vec2f &a = sheet.points[t[0]], &b = sheet.points[t[1]], &c = sheet.points[t[2]];
    const double d0 = sheet.disparities[t[0]], d1 = sheet.disparities[t[1]] - d0,
                 d2 = sheet.disparities[t[2]] - d0;
    if (std::max({0.0, d1, d2}) - std::min({0.0, d1, d2}) <= jump_px) return false;
    const double bx = static_cast<double>(b.x) - a.x, by = static_cast<double>(b.y) - a.y;
    const double cx = static_cast<double>(c.x) - a.x, cy = static_cast<double>(c.y) - a.y;
    const double area2 = std::abs(bx * cy - cx * by);
    if (area2 > 2 * kNeedle_px2) return false;
    return std::abs(d1 * cy - d2 * by) > area2 || std::abs(d2 * bx - d1 * cx) > area2;
}

// Takes the needles away, and the vertices that nothing then uses.
void drop_needles(SheetMesh& sheet, double jump_px) {
    std::erase_if(sheet.triangles, [&](const Triangle& t) { return is_needle(sheet, t, jump_px); });
    constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
    std::vector<std::uint32_t> place(sheet.points.size(), kUnused);
    for (const Triangle& t : sheet.triangles)
        for (const std::uint32_t v : t) place[v] = 0;
    std::uint32_t used = 0;
    for (std::size_t v = 0; v < place.size(); ++v) {
        if (place[v] == kUnused) continue;
        sheet.points[used] = sheet.points[v];
        sheet.disparities[used] = sheet.disparities[v];
        place[v] = used++;
    }
    sheet.points.resize(used);
    sheet.disparities.resize(used);
    for (Triangle& t : sheet.triangles)
        for (std::uint32_t& v : t) v = place[v];
}

}  // namespace

SheetMesh open_sheet(const SheetInput& input, const SheetConfig& config, int threads) {
    check(input);
    const double cell_px = static_cast<double>(input.map->values.size()) /
                           static_cast<double>(std::max<std::size_t>(1, input.mesh->positions.size()));
    Team team(threads);
    const PixelSurfaces surfaces =
        find_surfaces(*input.map, input.background_px, input.color, cell_px, config, team);
    HexMesh2D mesh = *input.mesh;
    const std::vector<std::uint8_t> on_rim = align_to_rims(surfaces, mesh, team);
    SplitLattice lattice = split_at_rims(surfaces, mesh, on_rim, team);
    SideFinder finder(surfaces, cell_px, team);
    const TriangleSides& sides = finder.sides();
    for (int round = 0;; ++round) {
        finder.update(lattice);
        finder.open_edges(lattice);
        fit_rims(surfaces, sides, lattice, team);
        finder.update(lattice);
        if (round == kRounds) break;
        split_mixed(surfaces, sides, lattice, team);
    }
    finder.open_edges(lattice);
    finder.join_cuts(lattice);
    finder.collect_pixels(lattice);
    SheetMesh sheet;
    std::vector<std::uint32_t> origins;
    const std::vector<std::uint32_t> olds = open_fans(lattice, sides, sheet.triangles, origins);
    for (const std::uint32_t v : olds) sheet.points.push_back(lattice.points[v]);
    if (config.rim_inset_px > 0)
        inset_rims(surfaces, *input.map, config.rim_inset_px, olds, sheet.triangles, sheet.points);
    sheet.disparities = fit_disparities(surfaces, sheet.points, sheet.triangles, sides, origins, team);
    if (config.discontinuities == Discontinuities::cut) drop_needles(sheet, surfaces.jump_px);
    return sheet;
}

}  // namespace hexrelief
