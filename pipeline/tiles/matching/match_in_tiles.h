// Matches a pair of any size to a disparity map, tile by tile.
#pragma once

#include <filesystem>

#include "mesher/tiles/lattice_tiles.h"
#include "pipeline/data/calibration.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/readers/windows/map_windows.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::tiles {

struct PairWindows {
    const readers::PictureWindows &left, &right;
};

// Returns the configuration's range, else the calibration's, else the range found in the whole pair,
// which is shrunk by a whole number if it has more than 16 Mpx. The correction of light and `coarse`
// come from the shrunk pair, the noise from the middle of the full one. A pair that is not shrunk
// gets the same as from find_range(), except that the range is not rounded up. Writes the range to
// the log. Throws as check_matchable().
stages::FoundRange find_range_of_whole(const PairWindows& pair, const Calibration& calibration,
                                       const stages::DisparityConfig& config, int threads, job::RunLog& log);

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

struct MatchRequest {
    std::filesystem::path left, right;  // a rectified pair, in formats of PictureWindows
    std::filesystem::path map;          // .tif, .tiff or .pfm, as for MapWriter
    int tile_px = 2048;                 // a tile's side, at least 16
    int collar_px = kCollar_px;
    config::Config config = {};  // checked and complete
};

struct TiledMatch {
    int width = 0, height = 0;  // size of the map
    int tiles = 0;
    double matched_share = 0, known_share = 0;  // share of the map's pixels
};

// Writes the left picture's disparities in px as 32-bit floats, as compute_disparity() finds them in each
// tile and its collar. +infinity is unknown; the left picture's transparent pixels are unknown if
// input.mask.alpha is set. The map appears as a whole at the end, or not at all. Memory: a row of tiles of
// the map, two windows of the pair (window_of_tile()), and what compute_disparity() takes for one window. The
// result is the same for any number of threads and on any backend.
//
// Throws Error(usage) for settings that tiles cannot have and as MapWriter; Error(input) as
// PictureWindows and compute_disparity(), if nothing matches, and if the calibration describes an
// unrectified pair; Error(output) as MapWriter.
TiledMatch match_in_tiles(const MatchRequest& request, job::Backend& backend, job::RunLog& log);

}  // namespace hexrelief::tiles
