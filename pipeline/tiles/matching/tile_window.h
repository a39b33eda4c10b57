// Which part of a pair one tile of its map is matched in.
#pragma once

#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::tiles {

// Pixels around a tile that are matched with it, and then left out: what lies farther away changes the tile's
// disparities no more than EXPERIMENTS.md says.
inline constexpr int kCollar_px = 192;

struct PairSize {
    int width = 0, height = 0;
};

// The same rectangle of both pictures: the tile with a collar around it, and with the columns of the right
// picture that its disparities reach. It begins at even columns and rows, so that the pair at half size has
// the same pixels in all windows; it is as wide as the range where the pair is. ranged: with a range.
mesh_tiles::MapRect window_of_tile(const mesh_tiles::MapRect& tile, const PairSize& whole,
                                   const stages::DisparityConfig& ranged, int collar_px = kCollar_px);

}  // namespace hexrelief::tiles
