// The recipe of surface_oracle.h, step by step.
#include "surface_oracle.h"

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
Mesh cut_disparity_mesh(HexMesh2D lattice, const DisparityMap& map, float background_px,
                        const Config& config) {
    const double cell_px =
        static_cast<double>(map.values.size()) / static_cast<double>(lattice.positions.size());
    const Surfaces s = find_surfaces(map, background_px, cell_px, config);
    const std::vector<bool> on_silhouette = snap_vertices(s, lattice);
    PlaneMesh mesh = triangles_of(lattice);
    split_at_silhouettes(s, on_silhouette, mesh);
    for (int round = 0; round < config.split_rounds; ++round) {
        split_straddling(s, label_triangles(s, mesh, cell_px).straddling, mesh);
        const Labels labels = label_triangles(s, mesh, cell_px);
        fit_silhouettes(s, labels.kept, vote_on_edges(s, mesh, labels), mesh);
    }
    const Labels labels = label_triangles(s, mesh, cell_px);
    CutEdges cut = vote_on_edges(s, mesh, labels);
    join_cuts(mesh, labels, cut);
    CutMesh cut_mesh = cut_vertices(mesh, labels.kept, cut);
    if (config.inset_px > 0) inset_silhouettes(s, map, config.inset_px, mesh, labels.kept, cut, cut_mesh);
    return {cut_mesh.points, fit_disparities(s, labels, cut_mesh), cut_mesh.triangles};
}

}  // namespace hexrelief::surface::oracle
