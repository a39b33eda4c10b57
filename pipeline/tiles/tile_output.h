// Writes a tile's files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "mesher/tiles/tile_surface.h"
#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/files/output_set.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct TileScene {
    // positions: exact multiples of the plan's grid step, relative to the tile's own origin;
    // texcoords: within the window.
    SurfaceMesh mesh;
    std::array<double, 3> origin_m = {};            // of the tile in space, a multiple of the step
    std::array<double, 3> low_m = {}, high_m = {};  // bounding box in space
};

// Places a tile in space. `window` is the part of the picture that the tile is textured with. A corner has
// the same position in every tile, to the bit. Corners without a position (d + doffs <= 0) are left out with
// their triangles. Throws Error(input) if the tile is too large for the grid.
TileScene tile_scene(const TilePlan& plan, const mesh_tiles::TileMesh& mesh,
                     const mesh_tiles::MapRect& window);

// Joins crumbs to what is beside them, as stages::join_crumbs() does, but none with seam edges. `window`
// contains the tile, whose lattice has cells of cell_px pixels.
void join_crumbs(mesh_tiles::TileMesh& mesh, const mesh_tiles::MapRect& window, double cell_px);

// Drops components of fewer than min_triangles triangles without seam edges, which are therefore complete.
void drop_specks(mesh_tiles::TileMesh& mesh, int min_triangles);

struct TileReport {
    std::string plan;  // TilePlan::stamp
    std::size_t vertices = 0, triangles = 0, seam_edges = 0;
    std::array<double, 3> low_m = {}, high_m = {};  // bounding box in space; zeros if the tile is empty
    // Root mean square differences between surface and map, over the foreground pixels that the surface
    // covers, in some of the rows.
    double error_px = 0, error_m = 0;
    std::vector<files::WrittenFile> files;  // names within the plan's folder
};

// Reads a report. Throws Error(input) if it is missing or malformed.
TileReport read_tile_report(const std::filesystem::path& path);

// Writes together the tile's .mesh, its .glb unless it is empty, and last its .json, the report,
// whose remaining fields are filled in. texture: that of the scene's texture coordinates; may be
// null. Up to `threads` threads compress.
void write_tile(const TilePlan& plan, const TileNumber& tile, const mesh_tiles::TileMesh& mesh,
                const TileScene& scene, const Image* texture, int threads, TileReport report);

// True if the tile's report belongs to this plan and its files are as the report says.
bool is_solved(const TilePlan& plan, const TileNumber& tile);

}  // namespace hexrelief::tiles
