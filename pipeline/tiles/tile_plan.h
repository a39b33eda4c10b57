// A tile plan: the data that all tiles of a map share, found once and kept in a folder.
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
#include "pipeline/readers/windows/map_windows.h"
#include "pipeline/stages/density.h"

namespace hexrelief::tiles {

// The largest width or height of the map: places are 32-bit numbers of 1/1024 px.
inline constexpr int kLargestTiledSide_px = 2'000'000;

// A file as it was when the plan was made. Its bytes are not hashed, because they may be many.
struct PlannedFile {
    std::filesystem::path path;  // absolute; empty = none
    std::uint64_t bytes = 0;
    std::int64_t modified_ns = 0;

    bool operator==(const PlannedFile&) const = default;
};
// Describes a file. Throws Error(input) if it does not exist.
PlannedFile planned_file(const std::filesystem::path& path);

// The level of detail, column and row of a tile. Level 0 is one tile that covers the whole map; each tile has
// up to four tiles of the next level in it. The tiles of the plan are those of the finest level.
struct TileNumber {
    int level = 0, i = 0, j = 0;
    friend bool operator==(const TileNumber&, const TileNumber&) = default;
};

struct TilePlan {
    std::filesystem::path folder;
    std::string stamp;  // SHA-256 of everything that the tiles' bytes depend on
    PlannedFile map, color;
    std::optional<readers::RawMapLayout> raw;
    config::Config config;    // effective; after read_plan(), run.backend and run.threads have their defaults
    Calibration calibration;  // of the map; cx and cy are multiples of 1/1024 px
    int width = 0, height = 0;
    int columns = 0, rows = 0, tile_spacings = 0;  // of the lattice and of a tile, as in LatticeTiling
    int shrunk_by = 2;                             // factor by which the map is shrunk for the coarse lattice
    stages::DensityScale density;
    float nearest_px = 0, farthest_px = 0;    // the largest and the smallest disparity above 0
    double grid_step_m = 0;                   // of all positions in space, a power of two
    std::map<std::string, std::string> sums;  // SHA-256 of the plan's other files, by name in the folder

    mesh_tiles::LatticeTiling tiling() const { return {columns, rows, tile_spacings}; }
    int finest_level() const;
};

// Returns all tiles of a level, row by row.
std::vector<TileNumber> tiles_of_level(const TilePlan& plan, int level);
// Returns the tiles of the next level that are within `tile`, row by row: one to four.
std::vector<TileNumber> children_of(const TilePlan& plan, const TileNumber& tile);
// Returns "(row, column)", and for coarser levels "(row, column) of level 2".
std::string tile_name(const TilePlan& plan, const TileNumber& tile);

// The names of a plan's files.
std::filesystem::path plan_file(const std::filesystem::path& folder);         // plan.json
std::filesystem::path plan_config_file(const std::filesystem::path& folder);  // config.yaml
std::filesystem::path coarse_file(const TilePlan& plan);
std::filesystem::path row_seam_file(const TilePlan& plan, int j);
std::filesystem::path column_seam_file(const TilePlan& plan, int i, int j);
// Returns the path "tiles/4/12/3.glb" for level 4, column 12, row 3, as 3D Tiles' templates name it;
// `extension` includes its dot.
std::filesystem::path tile_file(const TilePlan& plan, const TileNumber& tile, const std::string& extension);

// Writes plan.json and config.yaml; to be called last on the set that holds the plan's other files.
// Sets the plan's stamp.
void write_plan(TilePlan& plan, files::OutputSet& files);

// Reads a plan. Throws Error(input) if the folder holds no plan or one of another version, if the
// configuration is damaged, or if the map or the picture has changed since.
TilePlan read_plan(const std::filesystem::path& folder);

// Throws Error(input) if a file of the plan is missing or has changed.
void check_planned_file(const TilePlan& plan, const std::filesystem::path& path);

}  // namespace hexrelief::tiles
