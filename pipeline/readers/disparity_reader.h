// Reads supplied disparity maps.
#pragma once

#include <filesystem>
#include <limits>
#include <string>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/value_range.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

// No view is as wide as this. Disparities beyond it, positive or negative, are unknown.
inline constexpr double kLargestDisparity_px = 1e6;

// The conversion of a map file's samples to disparities in px: d = raw / scale + offset. `raw` is the number
// in the file: it is scaled neither by a PGM's maxval nor by the width of 1-2-4-bit PNG or TIFF samples
// (which are read as 8-bit maps).
struct DisparityFileConfig {
    // 0 = not given: an 8-bit integer map is then refused with a list of Middlebury's scales, a 16-bit one is
    // read as KITTI's (256), one of signed integers as StereoSGBM's (16) or refused, floats are px already.
    // Below 0: the file's disparities have the other sign.
    static constexpr ValueRange kScale{-65536, 65536};
    double scale = 0;
    static constexpr ValueRange kOffset_px{-65536, 65536};
    double offset_px = 0;
    // Raw value that means "unknown", compared before scale and offset; NaN, +-inf and what the file declares
    // are unknown besides. NaN = found in the samples: the least value below 0 if it is the only one or
    // stands alone, as StereoSGBM's does, and 0 if none is below; a given value replaces these. Middlebury:
    // 2001 venus has no unknown pixels, tsukuba 0 in a border; 2003 to 2006 have 0, 2014 (PFM) has +inf.
    double unknown = std::numeric_limits<double>::quiet_NaN();
    // Disparities of this and less are unknown. A caller that knows a camera's doffs keeps them at first.
    double beyond_px = 0;
    std::string key = {};  // array of an NPZ, channel of an EXR; empty = the only one, or the usual names
    Packing packing = Packing::none;  // of maps in a picture's colours
    bool flip = false;                // the rows are stored in the other order
    // The advice in errors: the caller's options, and their keys in brackets.
    std::string scale_option = "--disparity-scale (input.disparity.scale)";
    std::string unknown_option = "--unknown (input.disparity.unknown)";
};

// Returns a configuration that keeps all disparities, for a camera whose doffs is not known yet.
DisparityFileConfig before_doffs(DisparityFileConfig config);

struct DisparityFile {
    DisparityMap map;
    std::string believed = {};  // the assumed meaning of the samples: "16-bit integers, 1/256 px as KITTI's"
    bool is_scale_assumed = false;  // an integer map without a given scale
};

// Reads 8/16-bit grey PNG or PGM, PFM (Pf; the header's scale only gives the byte order; bottom row first),
// float or integer TIFF (GDAL's nodata is unknown), NPY, NPZ, EXR and others, recognised by content. Throws
// Error(input) if the file is missing, malformed, truncated, of zero size or too large; if it has colours
// whose channels differ, no known pixel, no scale for an 8-bit map, or floats that make sense only in the
// other byte order; and for formats that lose disparities (JPEG) or cannot hold them (WebP). Throws
// Error(usage) if the scale or the offset is out of range.
DisparityFile read_disparity_file(const std::filesystem::path& path, const DisparityFileConfig& config,
                                  const ReaderLimits& limits = {});
DisparityMap read_disparity_map(const std::filesystem::path& path, const DisparityFileConfig& config,
                                const ReaderLimits& limits = {});
// As read_disparity_file(), for samples of one channel that have been read already; errors name `path`.
DisparityFile disparities_of(codec::Raster raster, const std::filesystem::path& path,
                             const DisparityFileConfig& config);
// The map of disparities_of(), for a part of a map, in which all pixels may be unknown, and the value that
// means so is not looked for: it is 0 unless it is given.
DisparityMap disparities_of_part(codec::Raster raster, const std::filesystem::path& path,
                                 const DisparityFileConfig& config);

}  // namespace hexrelief::readers
