// Reads supplied depth maps.
#pragma once

#include <filesystem>
#include <limits>
#include <string>

#include "pipeline/data/depth_map.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

enum class DepthKind { depth, inverse_depth, affine_inverse, affine_depth };

// The meaning of the samples of a depth map's file.
struct DepthFileConfig {
    DepthKind kind = DepthKind::depth;
    // "m", "mm", or a number by which samples are divided to give metres (1 / metres if the kind is
    // inverse_depth). Empty = chosen by the samples: 16-bit integers are millimetres, floats are metres.
    std::string unit = {};
    bool ray = false;   // distances are along each pixel's ray instead of the optical axis
    double near_m = 0;  // depths below near_m or above far_m are unknown; 0 = no limit
    double far_m = 0;
    // affine_inverse: depth = 1 / (shift + scale * sample), affine_depth: depth = shift + scale * sample.
    // NaN = not given: if one of the two is given, the other is a shift of 0 or a scale of 1; if neither is,
    // they are such that the farthest is ten times as far as the nearest.
    double affine_shift = std::numeric_limits<double>::quiet_NaN();
    double affine_scale = std::numeric_limits<double>::quiet_NaN();
    // Sample value that means "unknown". NaN = the format's own: 0 in integer maps of depth and inverse
    // depth, and also the end of the range (65535) in maps of depth with 16-bit and wider integers.
    double unknown = std::numeric_limits<double>::quiet_NaN();
    std::string key = {};  // array of an NPZ, channel of an EXR; empty = the only one, or the usual names
    Packing packing = Packing::none;  // of maps in a picture's colours
    bool flip = false;                // the rows are stored in the other order
};

struct DepthFile {
    DepthMap map;            // neither projected on the axis nor clipped: ray, near_m and far_m are ignored
    std::string believed;    // the assumed meaning of the samples: "16-bit integers, mm"
    std::string doubt = {};  // a warning, if another meaning is as likely; empty = none
};

// Returns the error in a configuration, beginning with its key: an invalid unit, a scale of 0, or limits that
// leave no depth. Empty if there is none.
std::string wrong_depth_config(const DepthFileConfig& config);

// Reads the formats of read_disparity_map(), and HEIC's auxiliary depths. If a file states its kind, that
// replaces a configured `depth`. Samples that are NaN or infinite, and depths that are infinite or not above
// 0, are unknown. Throws Error(usage) if the configuration is wrong; Error(input) as read_disparity_map()
// does, and if the unit of integers is unknown: those of 8 bits, and those of inverse depth.
// said_per_m: integers in a metre by the camera's file, used for depths if no unit is configured; 0 = not
// said.
DepthFile read_depth_map(const std::filesystem::path& path, const DepthFileConfig& config,
                         const ReaderLimits& limits = {}, double said_per_m = 0);
// As read_depth_map(), for samples of one channel that have been read already; errors name `path`.
DepthFile depths_of(const codec::Raster& raster, const std::filesystem::path& path,
                    const DepthFileConfig& config, double said_per_m = 0);

}  // namespace hexrelief::readers
