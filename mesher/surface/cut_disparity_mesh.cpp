#include "mesher/surface/cut_disparity_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "mesher/surface/fit/fit_disparities.h"
#include "mesher/surface/fit/fit_silhouettes.h"
#include "mesher/surface/pixels/pixel_surfaces.h"
#include "mesher/surface/topology/cut_vertices.h"
#include "mesher/surface/topology/label_triangles.h"
#include "mesher/surface/topology/snap_vertices.h"
#include "mesher/surface/topology/split_triangles.h"
#include "pipeline/data/error.h"

namespace hexrelief::surface {
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
}

double cell_area_px(const DisparityMeshInput& input) {
    if (input.whole.cell_px > 0) return input.whole.cell_px;
    return static_cast<double>(input.map->values.size()) /
           static_cast<double>(std::max<std::size_t>(1, input.mesh->positions.size()));
}

step::LatticePart lattice_part(const DisparityMeshInput& input) {
    const WholeMap& whole = input.whole;
    const int columns = input.mesh->columns, of_whole = whole.columns > 0 ? whole.columns : columns;
    return {static_cast<std::uint32_t>(columns), static_cast<std::uint32_t>(of_whole),
            static_cast<std::uint32_t>(whole.first_row) * static_cast<std::uint32_t>(of_whole) +
                static_cast<std::uint32_t>(whole.first_column)};
}

DisparityMesh cut_disparity_mesh(const DisparityMeshInput& input, const SurfaceConfig& config, int threads) {
    check_disparity_mesh_input(input);
    const double cell_px = cell_area_px(input);
    ThreadPool pool(threads);
    const PixelSurfaces surfaces =
        find_pixel_surfaces(*input.map, input.background_px, cell_px, config, pool);
    HexMesh2D mesh = *input.mesh;
    const std::vector<std::uint8_t> on_silhouette =
        snap_to_silhouettes(surfaces, lattice_part(input), mesh, pool);
    SplitLattice lattice = split_at_silhouettes(surfaces, mesh, on_silhouette, pool);
    TriangleLabeler labeler(surfaces, cell_px, input.whole.nearest_px, pool);
    SilhouetteFitter silhouettes(surfaces, pool);
    const TriangleLabels& labels = labeler.labels();
    labeler.update(lattice);
    for (int round = 0; round < config.split_rounds; ++round) {
        split_straddling(surfaces, labels.straddling, lattice, pool);
        labeler.update(lattice);
        labeler.open_edges(lattice);
        silhouettes.fit(labels, lattice);
        labeler.update(lattice);
    }
    labeler.open_edges(lattice);
    labeler.join_cuts(lattice);
    labeler.collect_pixels(lattice);
    CutTriangles cut = cut_vertices(lattice, labels, pool);
    if (config.silhouette_inset_px > 0)
        inset_silhouettes(surfaces, *input.map, config.silhouette_inset_px, fans_of(lattice, labels), cut,
                          pool);
    DisparityMesh cut_mesh;
    cut_mesh.disparities = fit_disparities(surfaces, labels, cut, input.whole.farthest_px, pool);
    cut_mesh.points = std::move(cut.points);
    cut_mesh.triangles = std::move(cut.triangles);
    cut_mesh.has_one_fan_per_vertex = true;
    return cut_mesh;
}

}  // namespace hexrelief::surface
