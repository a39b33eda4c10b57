// Reads supplied disparity maps.
#pragma once

#include <filesystem>

#include "pipeline/data/disparity_map.h"

namespace hexrelief {

// How the samples of a map file become pixels of disparity: d = raw / scale + offset.
struct DisparityFileConfig {
    // 0 = not given: an integer map of 8 bits is then an error that lists Middlebury's scales, one of 16 bits is read as
    // KITTI (scale 256, 0 unknown), PFM and float TIFF are pixels already (scale 1).
    double scale = 0;
    double offset_px = 0;
    // raw value that means "not known"; NaN = the format's own: 0 in integer maps, NaN, +-inf (and 0 or less in float
    // maps) always mean unknown.
    double unknown = std::numeric_limits<double>::quiet_NaN();
};

// Reads 8/16-bit grey PNG or PGM, PFM (Pf; the header's scale is only the byte order; bottom row first) and float or
// integer TIFF, recognised by content. Throws Error(input): missing, malformed, truncated, zero or too large, colour where
// all channels differ, no known pixel at all, or no scale for an 8-bit map.
DisparityMap read_disparity_map(const std::filesystem::path& path, const DisparityFileConfig& config);

}  // namespace hexrelief
