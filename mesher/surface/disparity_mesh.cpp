#include "mesher/surface/disparity_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "mesher/surface/topology/snap_vertices.h"
#include "mesher/surface/fit/fit_silhouettes.h"
#include "mesher/surface/pixels/discontinuities.h"
#include "mesher/surface/topology/label_triangles.h"
#include "pipeline/data/error.h"

namespace hexrelief {
void check_sheet_input(const SheetInput& input) {
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

double cell_area_px(const SheetInput& input) {
    return static_cast<double>(input.map->values.size()) /
           static_cast<double>(std::max<std::size_t>(1, input.mesh->positions.size()));
}

SheetMesh open_sheet(const SheetInput& input, const SheetConfig& config, int threads) {
    check_sheet_input(input);
    const double cell_px = cell_area_px(input);
    Team team(threads);
    const PixelSurfaces surfaces =
        find_surfaces(*input.map, input.background_px, input.color, cell_px, config, team);
    HexMesh2D mesh = *input.mesh;
    const std::vector<std::uint8_t> on_rim = align_to_rims(surfaces, mesh, team);
    SplitLattice lattice = split_at_rims(surfaces, mesh, on_rim, team);
    SideFinder finder(surfaces, cell_px, team);
    const TriangleSides& sides = finder.sides();
    RimFitter rims(surfaces, team);
    finder.update(lattice);
    for (int round = 0; round < config.split_rounds; ++round) {
        split_mixed(surfaces, sides, lattice, team);
        finder.update(lattice);
        finder.open_edges(lattice);
        rims.fit(sides, lattice, step::rim_least_move_px(round, config.split_rounds));
        finder.update(lattice);
    }
    finder.open_edges(lattice);
    finder.join_cuts(lattice);
    finder.collect_pixels(lattice);
    SheetMesh sheet;
    std::vector<std::uint32_t> origins;
    const std::vector<std::uint32_t> olds = open_fans(lattice, sides, sheet.triangles, origins, team);
    for (const std::uint32_t v : olds) sheet.points.push_back(lattice.points[v]);
    sheet.torn.emplace();
    if (config.rim_inset_px > 0)
        inset_rims(surfaces, *input.map, config.rim_inset_px,
                   {lattice, sides, olds, sheet.triangles, origins}, sheet.points, team);
    sheet.disparities = fit_disparities(surfaces, sheet.points, sheet.triangles, sides, origins, team);
    if (config.discontinuities == Discontinuities::cut) drop_needles(sheet, surfaces.jump_px, team);
    return sheet;
}

}  // namespace hexrelief
