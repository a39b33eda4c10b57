// Reads supplied disparity maps.
#pragma once

#include <filesystem>
#include <limits>
#include <string>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/value_range.h"
#include "pipeline/readers/limits.h"
#include "pipeline/readers/raster.h"

namespace hexrelief {

// No view is as wide. What is beyond, up or down, is not known.
inline constexpr double kLargestDisparity_px = 1e6;

// How the samples of a map file become pixels of disparity: d = raw / scale + offset. raw is the number in
// the file: it is not scaled by a PGM's maxval, nor by the width of 1-2-4-bit PNG or TIFF samples (which are
// read as 8-bit maps).
struct DisparityFileConfig {
    // 0 = not given: an integer map of 8 bits is then an error that lists Middlebury's scales, one of 16 bits
    // is read as KITTI (scale 256, 0 unknown), PFM and float TIFF are pixels already (scale 1).
    static constexpr ValueRange kScale{0, 65536};
    double scale = 0;
    static constexpr ValueRange kOffset_px{-65536, 65536};
    double offset_px = 0;
    // raw value that means "not known", compared before scale and offset. NaN = the format's own, which is 0
    // in integer maps; another value given replaces that 0, so 0 is then a disparity like any other. In float
    // maps NaN, +-inf and 0 or less are unknown whatever is given here. Middlebury: 2001 venus has no unknown
    // pixels, tsukuba 0 in a border, 2003 to 2006 have 0, 2014 (PFM) has +inf.
    double unknown = std::numeric_limits<double>::quiet_NaN();
    std::string key = {};  // array of an NPZ, channel of an EXR; empty = the only one, or the usual names
    // What errors advise to give: the options, and in brackets the keys, of those who call.
    std::string scale_option = "--disparity-scale (input.disparity.scale)";
    std::string unknown_option = "--unknown (input.disparity.unknown)";
};

// Reads 8/16-bit grey PNG or PGM, PFM (Pf; the header's scale is only the byte order; bottom row first),
// float or integer TIFF (GDAL's nodata is unknown), NPY, NPZ and EXR, recognised by content. Throws
// Error(input): missing, malformed, truncated, zero or too large, colour where channels differ, no known
// pixel at all, no scale for an 8-bit map, floats that only make sense in the other byte order, or a format
// that loses (JPEG) or has no room for (WebP) disparities. Throws Error(usage) for a scale or an offset out
// of range.
DisparityMap read_disparity_map(const std::filesystem::path& path, const DisparityFileConfig& config,
                                const ReaderLimits& limits = {});
// The same of samples of one channel that were read already; errors name `path`.
DisparityMap disparities_of(codec::Raster raster, const std::filesystem::path& path,
                            const DisparityFileConfig& config);
// The same of a part of a map, of which no pixel need be known.
DisparityMap disparities_of_part(codec::Raster raster, const std::filesystem::path& path,
                                 const DisparityFileConfig& config);

}  // namespace hexrelief
