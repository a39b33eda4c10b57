// Cuts the lattice along silhouettes, at depth discontinuities, and fits disparities to its vertices.
#pragma once

#include "mesher/common/surface_config.h"
#include "mesher/surface/topology/snap_vertices_step.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/disparity_mesh.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::surface {

// The whole map and lattice that the given ones are parts of. Zeros: the given ones are the whole.
struct WholeMap {
    double cell_px = 0;                     // mean area of a lattice cell
    float nearest_px = 0, farthest_px = 0;  // largest disparity, and smallest one above 0
    int columns = 0;                        // columns of the whole lattice
    int first_column = 0, first_row = 0;    // first column and row of the part in the whole lattice
};

struct DisparityMeshInput {
    const HexMesh2D* mesh = nullptr;    // not null
    const DisparityMap* map = nullptr;  // not null, of the image that the mesh covers
    float background_px = 0;            // lower disparities, and those not above 0, are background
    WholeMap whole = {};
};

// Cuts the mesh of `input` and fits its disparities. The steps, one header each:
//  1. pixels/pixel_surfaces.h: depth discontinuities between neighbouring pixels; holes and speckles are
//     merged into their surroundings (pixels/pixel_surfaces_step.h)
//  2. topology/snap_vertices.h: lattice vertices move onto the silhouettes that these form
//  3. topology/split_triangles.h: triangles whose edges still cross a silhouette are split there
//  4. topology/label_triangles.h: each triangle gets the surface of most of its pixels as its label
// Then, config.split_rounds times:
//  5. topology/split_triangles.h: triangles that straddle two surfaces are split at their boundary
//  6. topology/label_triangles.h: new labels, and a vote of pixel pairs on which edges are open
//  7. fit/fit_silhouettes.h: silhouette vertices move by least squares; new labels
// And last:
//  8. topology/label_triangles.h: the last vote on edges; open edges are joined to longer cuts
//  9. topology/label_triangles.h: collects the pixels that each triangle's surface is fitted to
// 10. topology/cut_vertices.h: triangles off the foreground are dropped, each vertex fan gets its own vertex
// 11. fit/fit_silhouettes.h: silhouettes at high steps move inwards, if config.silhouette_inset_px > 0
// 12. fit/fit_disparities.h: the vertices' disparities, by least squares
//
// Returns the same bytes for any number of threads >= 1. A part of a map (see `whole`) gives the same
// triangles as the whole map, to the bit, at least 16 lattice spacings inside the part's lattice, if that
// lattice starts at an even row, its px differ from the whole's by whole numbers, all positions are multiples
// of 1/1024 px below 8192 px, and disparities are multiples of 1/65536 px. Throws Error(input) if the sizes
// do not fit or the map is empty.
DisparityMesh cut_disparity_mesh(const DisparityMeshInput& input, const SurfaceConfig& config, int threads);

// Throws Error(input) if cut_disparity_mesh() would.
void check_disparity_mesh_input(const DisparityMeshInput& input);

// Returns the mean area of a lattice cell, px2.
double cell_area_px(const DisparityMeshInput& input);

// Returns the position of the lattice within the whole one.
step::LatticePart lattice_part(const DisparityMeshInput& input);

}  // namespace hexrelief::surface
