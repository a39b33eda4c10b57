// The data that the parts of the surface stage share: views of device memory, which kernels take by value.
#pragma once

#include <cstdint>

#include "cuda/common/launch.h"
#include "mesher/common/surface_config.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "mesher/surface/topology/rasterize_step.h"
#include "mesher/surface/topology/snap_vertices_step.h"
#include "mesher/surface/topology/triangle_shape_step.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::cuda {

// The sizes of the arrays.
struct SurfaceSizes {
    int width, height;        // px of the map
    int columns, rows;        // of the lattice
    unsigned most_points;     // capacity for vertices of the split lattice
    unsigned most_triangles;  // capacity for triangles of the split lattice and of the mesh
    HEXRELIEF_HD unsigned pixels() const { return static_cast<unsigned>(width) * height; }
    HEXRELIEF_HD unsigned vertices() const { return static_cast<unsigned>(columns) * rows; }
};

// Capacity for the runs of all triangles: one per pixel would be enough if no triangles overlapped.
HEXRELIEF_HD unsigned run_capacity(const SurfaceSizes& sizes) {
    return sizes.pixels() + sizes.most_triangles;
}

// Number of words of FlagWords in a row.
HEXRELIEF_HD unsigned flag_words_per_row(int width) {
    return width / 32 + 2;
}

// Counts and limits that only the device knows until the end.
struct SurfaceTotals {
    unsigned mesh_points, mesh_triangles;  // of the mesh
    // Missing capacity; if it is not 0, no other member is valid, and later kernels do nothing. A kernel
    // writes it after a barrier, so that all of its threads have read the same value.
    unsigned missing_capacity;
    float discontinuity_px;
    float nearest_px, farthest_px;  // largest and smallest disparity of the foreground
};

// Counts of the split lattice. A kernel reads them before its first barrier and writes them after it.
struct SplitCounts {
    unsigned points, triangles;
    unsigned known;  // number of triangles at the last update of the labels
    unsigned votes;  // number of votes on the edges so far
};

// The device's form of PixelSurfaces.
struct DevicePixels {
    const float* map;  // px, +inf = unknown
    float* disparity;
    std::uint8_t* flags;
    std::uint32_t* tile_sums;
};

// The device's form of SplitLattice.
struct DeviceLattice {
    Vec2f* points;
    Triangle* triangles;
    std::int32_t (*neighbours)[3];
    std::uint8_t* changed;
    std::uint8_t* on_silhouette;  // of the lattice's own vertices
};

// The device's form of TriangleLabels.
struct SurfaceLabels {
    std::uint8_t* kept;
    std::uint32_t* anchors;
    std::uint8_t* straddling;
    std::uint8_t (*open)[3];
    std::uint32_t* run_starts;
    surface::PixelRun* runs;
};

// The device's form of DisparityMesh, with the source triangles of its triangles in the split lattice.
struct CutMesh {
    Vec2f* points;
    Triangle* triangles;
    float* disparities;
    std::uint32_t* source_triangles;
};

// All views and parameters of the surface stage.
struct SurfaceState {
    SurfaceSizes sizes;
    SurfaceConfig config;
    float background_px;
    double cell_px;                 // area of a lattice cell
    float nearest_px, farthest_px;  // disparities of the whole map that count along with this map's
    step::LatticePart part;
    GridBoard* board;
    SurfaceTotals* totals;
    SplitCounts* counts;
    DevicePixels pixels;
    DeviceLattice lattice;
    SurfaceLabels labels;
    CutMesh cut_mesh;

    // True if one connected mesh spans all discontinuities.
    HEXRELIEF_HD step::PixelView view() const {
        return {sizes.width, sizes.height, pixels.disparity, pixels.flags};
    }
    // For kernels: it reads the totals.
    HEXRELIEF_HD step::MeshTriangles mesh_triangles() const {
        return {totals->mesh_points, totals->mesh_triangles, cut_mesh.triangles, cut_mesh.source_triangles};
    }
    HEXRELIEF_HD step::TileView tiles() const {
        return {sizes.width, sizes.height, step::tile_sum_count(sizes.width), pixels.tile_sums};
    }
};

}  // namespace hexrelief::cuda
