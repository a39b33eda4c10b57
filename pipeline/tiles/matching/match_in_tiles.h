// Matches a pair of any size to a disparity map, tile by tile.
#pragma once

#include <filesystem>

#include "pipeline/job/backend.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/tiles/matching/tile_window.h"

namespace hexrelief::tiles {

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
