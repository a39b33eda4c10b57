// One lattice over a map of any size, in tiles that are solved apart and still fit together to the bit.
//
// Between neighbouring tiles lies a seam: a strip of lattice rings on both sides of their common border.
// Seams are solved first, each on the pixels around it, and their inner rings stay from then on. A tile's
// block is the tile with the inner rings of the seams around it, of which only the vertices between still
// move. So both neighbours know the same vertices near their border, and cut_disparity_mesh() finds the same
// triangles there.
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

// Whole 1/1024 px of the whole map: sums and differences are exact.
struct Place {
    std::int32_t x = 0, y = 0;
    friend auto operator<=>(const Place& a, const Place& b) = default;
};
inline constexpr int kPlacesPerPixel = 1024;

struct MapRect {
    int x = 0, y = 0, width = 0, height = 0;  // px of the whole map
};

// Rings of a seam on each side of its border. kHeldRings stay, more than the 16 that cut_disparity_mesh()
// needs; those up to kSeamRings are where a tile begins, or nothing could mend a fold beside those that stay;
// those beyond are solved with the seam, and then left out.
inline constexpr int kHeldRings = 18, kSeamRings = 24, kSeamBeyond = 12;

// columns x rows vertices, parted by border columns and rows that are `spacings` apart. The last tile of a
// row or column is up to half as large again.
class LatticeTiling {
  public:
    // spacings is rounded to a multiple of 6, at least kLeastTile: so blocks begin at even rows and at
    // centres of honeycomb cells.
    LatticeTiling(int columns, int rows, int spacings);
    static constexpr int kLeastTile = 2 * (kSeamRings + kSeamBeyond) + 6;

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    int across() const { return across_; }  // tiles
    int down() const { return down_; }
    // Vertices that tile i begins at; of i = across(), down(): the last vertex.
    int column_of(int i) const { return i < across_ ? i * spacings_ : columns_ - 1; }
    int row_of(int j) const { return j < down_ ? j * spacings_ : rows_ - 1; }

  private:
    int columns_, rows_, spacings_, across_, down_;
};

// A part of the whole lattice.
struct LatticeBlock {
    int first_column = 0, first_row = 0, columns = 0, rows = 0;
    std::vector<Place> places;  // columns * rows, row-major

    int end_column() const { return first_column + columns; }
    int end_row() const { return first_row + rows; }
    // Of the whole lattice's vertex, which lies in the block.
    const Place& at(int column, int row) const {
        return places[static_cast<std::size_t>(row - first_row) * columns + (column - first_column)];
    }
};

// A solved seam. Of its vertices those from (first_column, first_row) to (end_column - 1, end_row - 1) stay.
struct Seam {
    LatticeBlock block;
    int first_column = 0, first_row = 0, end_column = 0, end_row = 0;

    bool holds(int column, int row) const {
        return column >= first_column && column < end_column && row >= first_row && row < end_row;
    }
};

// The solved lattice of the map shrunk by a power of two, which the tiles begin from.
struct CoarseLattice {
    HexMesh2D mesh;             // in px of the shrunk map
    int shrunk_by = 1;          // a power of two
    int width = 0, height = 0;  // px of the whole map
};

// The density of a window of the map; throws what reading throws.
using DensityOfWindow = std::function<DensityMap(const MapRect&)>;

// balance_patch(), on the CPU or on a device.
using BalancePatch =
    std::function<void(const DensityMap&, const BalanceConfig&, int threads, balance::LatticePatch&)>;

class TileSolver {
  public:
    // References are kept.
    TileSolver(const LatticeTiling& tiling, const CoarseLattice& coarse, const BalanceConfig& config,
               const DensityOfWindow& density, int threads, BalancePatch balance = balance::balance_patch)
        : tiling_(tiling),
          coarse_(coarse),
          config_(config),
          density_(density),
          threads_(threads),
          balance_(std::move(balance)) {}

    // The seam between the tile rows j - 1 and j, 0 < j < down(), over all columns.
    Seam row_seam(int j) const;
    // The seam between the tiles (i - 1, j) and (i, j), 0 < i < across(), up to the row seams above and below
    // it; null: there is none.
    Seam column_seam(int i, int j, const Seam* above, const Seam* below) const;
    // The block of tile (i, j) with the seams around it: above, below, left, right; null: there is none.
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

// Floats hold a place exactly within a window of up to 16,384 px.
Vec2f in_window(const Place& place, const MapRect& window);
Place place_of(const Vec2f& point, const MapRect& window);

// The pixels around a block, with a margin, within the map.
MapRect window_of(const LatticeBlock& block, int margin_px, int width, int height);

}  // namespace hexrelief::mesh_tiles
