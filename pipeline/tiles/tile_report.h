// The report of a solved tile: its .json, whose presence means that the tile's files are complete.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pipeline/files/output_set.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct TileReport {
    std::string plan;  // TilePlan::stamp
    std::size_t vertices = 0, triangles = 0, seam_edges = 0;
    std::array<double, 3> low_m = {}, high_m = {};  // bounding box in space; zeros if the tile is empty
    // Root mean square differences between surface and map, over the foreground pixels that the surface
    // covers, in some of the rows.
    double error_px = 0, error_m = 0;
    std::vector<files::WrittenFile> files;  // names within the plan's folder
};

std::string report_text(const TileReport& report);
// Reads a report. Throws Error(input) if it is missing or malformed.
TileReport read_tile_report(const std::filesystem::path& path);

}  // namespace hexrelief::tiles
