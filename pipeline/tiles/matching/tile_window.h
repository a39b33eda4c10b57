// Chooses the part of a pair in which one tile of its map is matched.
#pragma once

#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::tiles {

// Width of the margin of pixels around a tile that are matched with it and then dropped: EXPERIMENTS.md says
// by how much pixels farther away can change the tile's disparities.
inline constexpr int kCollar_px = 192;

struct PairSize {
    int width = 0, height = 0;
};

// Returns the window, the same in both pictures: the tile with a collar around it, and with the columns of
// the right picture that its disparities reach. It begins at multiples of 32 px, so that the pair at half
// size has the same pixels in all windows, and is as wide as the range if the pair is. ranged: a
// configuration with a range.
mesh_tiles::MapRect window_of_tile(const mesh_tiles::MapRect& tile, const PairSize& whole,
                                   const stages::DisparityConfig& ranged, int collar_px = kCollar_px);

}  // namespace hexrelief::tiles
