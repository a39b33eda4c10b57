// One lattice over a map of any size, in tiles that are solved separately and still fit together to the bit.
//
// Between neighbouring tiles lies a seam: a strip of lattice rings on both sides of their common border.
// Seams are solved first, each on the pixels around it, and from then on their inner rings are held. A tile's
// block is the tile together with the inner rings of the seams around it; only the vertices between these
// rings still move. So both neighbours have the same vertices near their border, and cut_disparity_mesh()
// finds the same triangles there.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "mesher/balance/balance.h"
#include "mesher/common/mesh_config.h"
#include "pipeline/data/density_map.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::mesh_tiles {

// A position in the whole map, in units of 1/1024 px: sums and differences are exact.
struct Place {
    std::int32_t x = 0, y = 0;
    friend auto operator<=>(const Place& a, const Place& b) = default;
};
inline constexpr int kPlacesPerPixel = 1024;

struct MapRect {
    int x = 0, y = 0, width = 0, height = 0;  // px of the whole map
};

// Rings of a seam on each side of its border. The first kHeldRings are held, more than the 16 that
// cut_disparity_mesh() needs. The rings up to kSeamRings are start positions for the tiles, as otherwise a
// fold next to held rings could not be repaired. The kSeamBeyond rings further out are solved with the
// seam and then dropped.
inline constexpr int kHeldRings = 18, kSeamRings = 24, kSeamBeyond = 12;

// Divides columns x rows vertices into tiles by border columns and border rows that are `spacings` apart. The
// last tile of a row or column is up to half as large again.
class LatticeTiling {
  public:
    // Rounds `spacings` down to a multiple of 6, at least kLeastTile, so that blocks begin at even rows and
    // at centres of honeycomb cells.
    LatticeTiling(int columns, int rows, int spacings);
    static constexpr int kLeastTile = 2 * (kSeamRings + kSeamBeyond) + 6;

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    int across() const { return across_; }  // number of tiles in each direction
    int down() const { return down_; }
    // First column or row of tile i or j; for i = across() and j = down() the last one of the lattice.
    int column_of(int i) const { return i < across_ ? i * spacings_ : columns_ - 1; }
    int row_of(int j) const { return j < down_ ? j * spacings_ : rows_ - 1; }

  private:
    int columns_, rows_, spacings_, across_, down_;
};

// A part of the whole lattice.
struct LatticeBlock {
    int first_column = 0, first_row = 0, columns = 0, rows = 0;
    std::vector<Place> places;  // columns * rows, row by row

    int end_column() const { return first_column + columns; }
    int end_row() const { return first_row + rows; }
    // Returns the place of a vertex by its column and row in the whole lattice; it must lie in the block.
    const Place& at(int column, int row) const {
        return places[static_cast<std::size_t>(row - first_row) * columns + (column - first_column)];
    }
};

// A solved seam. Its vertices from (first_column, first_row) to (end_column - 1, end_row - 1) are held.
struct Seam {
    LatticeBlock block;
    int first_column = 0, first_row = 0, end_column = 0, end_row = 0;

    bool holds(int column, int row) const {
        return column >= first_column && column < end_column && row >= first_row && row < end_row;
    }
};

// The solved lattice of the shrunk map, from which the tiles start.
struct CoarseLattice {
    HexMesh2D mesh;             // in px of the shrunk map
    int shrunk_by = 1;          // a power of two
    int width = 0, height = 0;  // px of the whole map
};

// Returns the density of a window of the map; throws what reading throws.
using DensityOfWindow = std::function<DensityMap(const MapRect&)>;

// balance_patch(), on the CPU or on a device.
using BalancePatch =
    std::function<void(const DensityMap&, const BalanceConfig&, int threads, balance::LatticePatch&)>;

// Solves seams and tiles.
class TileSolver {
  public:
    // Keeps references to its arguments.
    TileSolver(const LatticeTiling& tiling, const CoarseLattice& coarse, const BalanceConfig& config,
               const DensityOfWindow& density, int threads, BalancePatch balance = balance::balance_patch)
        : tiling_(tiling),
          coarse_(coarse),
          config_(config),
          density_(density),
          threads_(threads),
          balance_(std::move(balance)) {}

    // Solves the seam between the tile rows j - 1 and j, 0 < j < down(), over all columns.
    Seam row_seam(int j) const;
    // Solves the seam between the tiles (i - 1, j) and (i, j), 0 < i < across(), up to the row seams above
    // and below it; null: there is no such seam.
    Seam column_seam(int i, int j, const Seam* above, const Seam* below) const;
    // Solves the block of tile (i, j) with the seams above, below, left and right of it; null: there
    // is no such seam.
    LatticeBlock tile(int i, int j, const std::array<const Seam*, 4>& seams) const;

  private:
    LatticeBlock block(int first_column, int first_row, int end_column, int end_row) const;
    void balance(std::span<const Seam* const> seams, LatticeBlock& block) const;

    const LatticeTiling& tiling_;
    const CoarseLattice& coarse_;
    const BalanceConfig& config_;
    const DensityOfWindow& density_;
    int threads_;
    BalancePatch balance_;
};

// Converts a place to px of a window and back. Floats hold it exactly in a window of up to 16,384 px.
Vec2f in_window(const Place& place, const MapRect& window);
Place place_of(const Vec2f& point, const MapRect& window);

// Returns the pixels around a block, with a margin, within the map of width x height px.
MapRect window_of(const LatticeBlock& block, int margin_px, int width, int height);

}  // namespace hexrelief::mesh_tiles
