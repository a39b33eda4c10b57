#include "mesher/surface/disparity_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "mesher/surface/fit/fit_silhouettes.h"
#include "mesher/surface/pixels/discontinuities.h"
#include "mesher/surface/topology/label_triangles.h"
#include "mesher/surface/topology/snap_vertices.h"
#include "pipeline/data/error.h"

namespace hexrelief {
void check_disparity_mesh_input(const DisparityMeshInput& input) {
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

double cell_area_px(const DisparityMeshInput& input) {
    return static_cast<double>(input.map->values.size()) /
           static_cast<double>(std::max<std::size_t>(1, input.mesh->positions.size()));
}

DisparityMesh cut_disparity_mesh(const DisparityMeshInput& input, const SurfaceConfig& config, int threads) {
    check_disparity_mesh_input(input);
    const double cell_px = cell_area_px(input);
    ThreadPool pool(threads);
    const PixelSurfaces surfaces =
        find_pixel_surfaces(*input.map, input.background_px, input.color, cell_px, config, pool);
    HexMesh2D mesh = *input.mesh;
    const std::vector<std::uint8_t> on_silhouette = snap_to_silhouettes(surfaces, mesh, pool);
    SplitLattice lattice = split_at_silhouettes(surfaces, mesh, on_silhouette, pool);
    TriangleLabeler finder(surfaces, cell_px, pool);
    const TriangleLabels& sides = finder.sides();
    SilhouetteFitter silhouettes(surfaces, pool);
    finder.update(lattice);
    for (int round = 0; round < config.split_rounds; ++round) {
        split_straddling(surfaces, sides, lattice, pool);
        finder.update(lattice);
        finder.open_edges(lattice);
        silhouettes.fit(sides, lattice, step::silhouette_least_move_px(round, config.split_rounds));
        finder.update(lattice);
    }
    finder.open_edges(lattice);
    finder.join_cuts(lattice);
    finder.collect_pixels(lattice);
    DisparityMesh cut_mesh;
    std::vector<std::uint32_t> source_triangles;
    const std::vector<std::uint32_t> source_vertices =
        split_non_manifold_vertices(lattice, sides, cut_mesh.triangles, source_triangles, pool);
    for (const std::uint32_t v : source_vertices) cut_mesh.points.push_back(lattice.points[v]);
    cut_mesh.non_manifold.emplace();
    if (config.silhouette_inset_px > 0)
        inset_silhouettes(surfaces, *input.map, config.silhouette_inset_px,
                          {lattice, sides, source_vertices, cut_mesh.triangles, source_triangles},
                          cut_mesh.points, pool);
    cut_mesh.disparities =
        fit_disparities(surfaces, cut_mesh.points, cut_mesh.triangles, sides, source_triangles, pool);
    if (config.discontinuities == Discontinuities::cut)
        remove_slivers(cut_mesh, surfaces.discontinuity_px, pool);
    return cut_mesh;
}

}  // namespace hexrelief
