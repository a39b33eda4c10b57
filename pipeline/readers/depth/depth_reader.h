// Reads supplied depth maps.
#pragma once

#include <filesystem>
#include <limits>
#include <string>

#include "pipeline/data/depth_map.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

enum class DepthKind { depth, inverse_depth, affine_inverse };

// What the samples of a depth map's file mean.
struct DepthFileConfig {
    DepthKind kind = DepthKind::depth;
    // "m", "mm", or a number: samples divided by it are metres; 1 / metres where the kind is inverse_depth.
    // Empty = by the samples: those of 16 bits are millimetres, floats are metres.
    std::string unit = {};
    bool ray = false;   // distances along each pixel's ray instead of along the optical axis
    double near_m = 0;  // depths outside of these are unknown; 0 = no limit on that side
    double far_m = 0;
    // affine_inverse: depth = 1 / (shift + scale * sample). NaN = not given: with one given, a shift of 0 or
    // a scale of 1; with neither, the ones by which the farthest is ten times as far as the nearest.
    double affine_shift = std::numeric_limits<double>::quiet_NaN();
    double affine_scale = std::numeric_limits<double>::quiet_NaN();
    // Sample that means "not known"; NaN = the format's own: 0 in integer maps of depth and inverse depth,
    // and 65535, which is the end of the range, in 16-bit maps of depth.
    double unknown = std::numeric_limits<double>::quiet_NaN();
    std::string key = {};  // array of an NPZ, channel of an EXR; empty = the only one, or the usual names
};

struct DepthFile {
    DepthMap map;  // neither projected on the axis nor clipped: ray, near_m and far_m are not looked at
    std::string believed;  // what the samples were taken for: "16-bit integers, mm"
};

// What is wrong with a configuration, beginning with its key: a unit that is none of the above, a scale of 0,
// or limits that leave no depth. Empty where nothing is.
std::string wrong_depth_config(const DepthFileConfig& config);

// Reads what read_disparity_map() reads, and HEIC's auxiliary depths, as a configuration without faults says;
// where a file states its kind, that is taken instead of `depth`. Samples that are NaN or infinite, and
// depths that are not above 0 or are infinite, are unknown. Throws Error(input) as read_disparity_map() does,
// and where integers do not say their unit: those of 8 bits, and those of inverse depth.
DepthFile read_depth_map(const std::filesystem::path& path, const DepthFileConfig& config,
                         const ReaderLimits& limits = {});
// The same of samples of one channel that were read already; errors name `path`.
DepthFile depths_of(const codec::Raster& raster, const std::filesystem::path& path,
                    const DepthFileConfig& config);

}  // namespace hexrelief::readers
