// Lays the lattice over the scene: along silhouettes, opened at depth discontinuities, at fitted disparities.
#pragma once

#include <cstdint>

#include "mesher/common/surface_config.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/disparity_mesh.h"
#include "pipeline/data/hex_mesh.h"
#include "pipeline/data/image.h"

namespace hexrelief {

struct DisparityMeshInput {
    const HexMesh2D* mesh = nullptr;    // not null
    const DisparityMap* map = nullptr;  // not null, of the image that the mesh covers
    float background_px = 0;            // disparities below, and those not above 0, are background
    const Image* color = nullptr;       // the left image, of the map's size; null = none
    // MeshResult's, where it was solved with the same map, unchanged since: it need not be copied to the
    // device again.
    std::uint64_t map_on_device = 0;
};

struct DisparityMeshResult {
    DisparityMesh cut_mesh;
    // Of a device, 0 on the CPU: its own clock's time without transfers, and the most that was taken of its
    // memory.
    double device_s = 0;
    std::size_t device_bytes = 0;
};

// 1. Depth discontinuities are found between neighbouring pixels (pixel_surfaces.h), borders of the
// foreground among them.
// 2. Vertices move onto the silhouettes that these form (align.h); where they cannot, triangles are split.
// 3. Each triangle gets the surface of most of its pixels; those on none are dropped; vertices between
// surfaces are
//    doubled.
// 4. Disparities are fitted to each triangle's own pixels, by least squares (steps/vertex_fit.h).
// 5. Small triangles that even so span a step are dropped: slivers in space.
// The same bytes for any number of threads. Throws Error(input) where the sizes do not fit or the map is
// empty.
DisparityMesh cut_disparity_mesh(const DisparityMeshInput& input, const SurfaceConfig& config, int threads);

// Throws Error(input) where cut_disparity_mesh() would.
void check_disparity_mesh_input(const DisparityMeshInput& input);

// Of a lattice cell, on average.
double cell_area_px(const DisparityMeshInput& input);

}  // namespace hexrelief
