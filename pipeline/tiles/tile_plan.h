// What all tiles of a map have in common: found once, kept in a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/config/config.h"
#include "pipeline/data/calibration.h"
#include "pipeline/files/output_set.h"
#include "pipeline/stages/density.h"
#include "pipeline/windows/map_windows.h"

namespace hexrelief::tiles {

// Places are 32-bit numbers of 1/1024 px.
inline constexpr int kLargestTiledSide_px = 2'000'000;

// A file as it was when the plan was made. Its bytes are not hashed: they may be many.
struct PlannedFile {
    std::filesystem::path path;  // absolute; empty = none
    std::uint64_t bytes = 0;
    std::int64_t modified_ns = 0;

    bool operator==(const PlannedFile&) const = default;
};
// Throws Error(input) where there is no such file.
PlannedFile planned_file(const std::filesystem::path& path);

// Of a level of detail: column and row. Level 0 is one tile that covers all of the map; each of a level's
// tiles has up to four of the next one in it. The tiles of the plan are those of the finest level.
struct TileNumber {
    int level = 0, i = 0, j = 0;
    friend bool operator==(const TileNumber&, const TileNumber&) = default;
};

struct TilePlan {
    std::filesystem::path folder;
    std::string stamp;  // SHA-256 of all that the tiles' bytes depend on
    PlannedFile map, color;
    std::optional<windows::RawMapLayout> raw;
    config::Config config;    // effective; read_plan() leaves run.backend and run.threads as by default
    Calibration calibration;  // of the map; cx and cy are multiples of 1/1024 px
    int width = 0, height = 0;
    int columns = 0, rows = 0, tile_spacings = 0;  // of the lattice and of a tile, as LatticeTiling's
    int shrunk_by = 2;                             // the map, for the coarse lattice
    stages::DensityScale density;
    float nearest_px = 0, farthest_px = 0;    // the largest and the smallest disparity above 0
    double grid_step_m = 0;                   // of all positions in space, a power of two
    std::map<std::string, std::string> sums;  // SHA-256 of the plan's other files, by name in the folder

    mesh_tiles::LatticeTiling tiling() const { return {columns, rows, tile_spacings}; }
    int finest_level() const;
};

// All of a level, row by row.
std::vector<TileNumber> tiles_of_level(const TilePlan& plan, int level);
// The tiles of the next level that are within `tile`, row by row: one to four.
std::vector<TileNumber> children_of(const TilePlan& plan, const TileNumber& tile);
// "(row, column)", and of coarser levels "(row, column) of level 2".
std::string tile_name(const TilePlan& plan, const TileNumber& tile);

// Names within a plan's folder.
std::filesystem::path plan_file(const std::filesystem::path& folder);         // plan.json
std::filesystem::path plan_config_file(const std::filesystem::path& folder);  // config.yaml
std::filesystem::path coarse_file(const TilePlan& plan);
std::filesystem::path row_seam_file(const TilePlan& plan, int j);
std::filesystem::path column_seam_file(const TilePlan& plan, int i, int j);
// "tiles/4/12/3.glb" of level 4, column 12, row 3, as 3D Tiles' templates name them; extension with its dot.
std::filesystem::path tile_file(const TilePlan& plan, const TileNumber& tile, const std::string& extension);

// plan.json and config.yaml, to be written last into the set that holds the plan's other files. Gives the
// plan its stamp.
void write_plan(TilePlan& plan, files::OutputSet& files);

// Throws Error(input) where the folder holds no plan, one of another version, the configuration is
// damaged, or the map or the picture has changed since.
TilePlan read_plan(const std::filesystem::path& folder);

// Throws Error(input) where a file of the plan is missing or not as the plan left it.
void check_planned_file(const TilePlan& plan, const std::filesystem::path& path);

}  // namespace hexrelief::tiles
