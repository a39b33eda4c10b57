// Reads masks and confidences, which say which pixels of a view count.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

// A mask: row-major, top row first.
struct PixelMask {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> kept;  // 1 = counts, 0 = is unknown

    bool empty() const { return kept.empty(); }
};

struct MaskConfig {
    bool inverted = false;  // 0 counts, any other value is unknown
    bool alpha = true;      // transparent pixels of the left picture are unknown as well
};

struct ConfidenceConfig {
    // Pixels of lower confidence are unknown. Floats are compared as they are. Integers are shares of the
    // largest value of their type (255, 65535), or of 2 if none is above 2, as in ARKit's levels 0, 1, 2.
    double threshold = 0.5;
    std::string key = {};  // array of an NPZ, channel of an EXR; empty = the only one, or the usual names
};

// Reads a mask from any image or map that the readers know. A pixel counts if one of its channels is not 0
// (NaN is 0) and it is not transparent. Palettes count by their colours. Throws Error(input) as read_image()
// does, and if no pixel counts.
PixelMask read_mask(const std::filesystem::path& path, const MaskConfig& config,
                    const ReaderLimits& limits = {});

// Reads a confidence map in any format of read_disparity_map(). NaN is below every threshold. Throws
// Error(input) as read_disparity_map() does, and if no pixel counts.
PixelMask read_confidence(const std::filesystem::path& path, const ConfidenceConfig& config,
                          const ReaderLimits& limits = {});

// As read_mask() and read_confidence(), for samples that have been read already; confidences must have one
// channel. Errors name `path`.
PixelMask mask_of(const codec::Raster& raster, const std::filesystem::path& path, const MaskConfig& config);
PixelMask confidence_of(const codec::Raster& raster, const std::filesystem::path& path,
                        const ConfidenceConfig& config);

// Returns the mask at another size: each pixel takes the value under its centre.
PixelMask resampled(const PixelMask& mask, int width, int height);

}  // namespace hexrelief::readers
