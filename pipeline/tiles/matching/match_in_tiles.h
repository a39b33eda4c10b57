// A pair of any size to its disparity map, tile by tile.
#pragma once

#include <filesystem>

#include "pipeline/job/backend.h"
#include "pipeline/job/run_log.h"
#include "pipeline/tiles/matching/tile_window.h"

namespace hexrelief {

struct MatchRequest {
    std::filesystem::path left, right;  // a rectified pair, as PictureWindows reads it
    std::filesystem::path map;          // .tif, .tiff or .pfm, as MapWriter writes it
    int tile_px = 2048;                 // a tile's side, at least 16
    int collar_px = kCollar_px;
    Config config = {};  // checked and complete
};

struct TiledMatch {
    int width = 0, height = 0;  // of the map
    int tiles = 0;
    double matched_share = 0, known_share = 0;  // of its pixels
};

// Writes the left picture's disparities in px, as compute_disparity() finds them in each tile and its collar,
// as 32-bit floats; +infinity is unknown, as are the left picture's transparent pixels where
// input.mask.alpha says so. The whole map appears at the end, or none. Memory: a row of tiles of the map, two
// windows of the pair (window_of_tile()), and what compute_disparity() takes for one. The same bytes for any
// number of threads and on any backend.
//
// Throws Error(usage) for settings that tiles cannot have and as MapWriter; Error(input) as
// PictureWindows and compute_disparity(), where nothing matches, and where the calibration says that the pair
// is not rectified; Error(output) as MapWriter.
TiledMatch match_in_tiles(const MatchRequest& request, Backend& backend, RunLog& log);

}  // namespace hexrelief
