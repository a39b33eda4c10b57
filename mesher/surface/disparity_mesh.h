// Lays the lattice over the scene: along silhouettes, cut at depth discontinuities, at fitted disparities.
#pragma once

#include <cstddef>

#include "mesher/common/surface_config.h"
#include "mesher/surface/topology/snap_vertices_step.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/disparity_mesh.h"
#include "pipeline/data/hex_mesh.h"
#include "pipeline/data/image.h"

namespace hexrelief {

// Where a map and its lattice are parts of larger ones: of the whole. Zeros: these are the whole.
struct WholeMap {
    double cell_px = 0;                     // area of a lattice cell, on average
    float nearest_px = 0, farthest_px = 0;  // the largest and the smallest disparity above 0
    int columns = 0;                        // of the lattice
    int first_column = 0, first_row = 0;    // where the part begins in it
};

struct DisparityMeshInput {
    const HexMesh2D* mesh = nullptr;    // not null
    const DisparityMap* map = nullptr;  // not null, of the image that the mesh covers
    float background_px = 0;            // disparities below, and those not above 0, are background
    const Image* color = nullptr;       // the left image, of the map's size; null = none
    WholeMap whole = {};
};

struct DisparityMeshResult {
    DisparityMesh cut_mesh;
    // Of a device, 0 on the CPU: its own clock's time without transfers, and the most that was taken of its
    // memory.
    double device_s = 0;
    std::size_t device_bytes = 0;
};

// The recipe, a step a header:
//  1. pixels/discontinuities.h   depth discontinuities between neighbouring pixels; holes and speckles join
//                                what surrounds them (pixels/speckles.h)
//  2. topology/snap_vertices.h   lattice vertices move onto the silhouettes that these form
//  3. topology/split_triangles.h triangles whose edges still cross a silhouette are split there
//  4. topology/label_triangles.h each triangle gets the surface that most of its pixels belong to
//     Then, config.split_rounds times:
//  5.   topology/split_triangles.h triangles that straddle two surfaces are split where these meet
//  6.   topology/label_triangles.h labels again, and a vote of pixel pairs on which edges are open
//  7.   fit/fit_silhouettes.h      vertices of silhouettes move by least squares; labels again
//  8. topology/label_triangles.h the last vote on edges; open edges are joined to longer cuts
//  9. topology/label_triangles.h the pixels that each triangle's surface is fitted to
// 10. topology/cut_vertices.h    triangles off the foreground are dropped, each vertex fan gets its own
// vertex
// 11. fit/inset_silhouettes.h    silhouettes at high steps move inwards, if config.silhouette_inset_px > 0
// 12. fit/fit_disparities.h      the vertices' disparities, by least squares
//
// The same bytes for any number of threads >= 1. A part of a map (`whole` says of which) gives the same
// triangles as the whole map, to the bit, from 16 lattice spacings inside of the part's lattice on, if that
// starts at an even row, its px and the whole's differ by whole numbers, all places are whole numbers of
// 1/1024 px below 8192 px, and disparities whole numbers of 1/65536 px. Throws Error(input) where the sizes
// do not fit or the map is empty.
DisparityMesh cut_disparity_mesh(const DisparityMeshInput& input, const SurfaceConfig& config, int threads);

// Throws Error(input) where cut_disparity_mesh() would.
void check_disparity_mesh_input(const DisparityMeshInput& input);

// Of a lattice cell, on average.
double cell_area_px(const DisparityMeshInput& input);

step::LatticePart lattice_part(const DisparityMeshInput& input);

}  // namespace hexrelief
