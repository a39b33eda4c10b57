// Reads which pixels of a view count: masks and confidences.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

// Row-major, top row first.
struct PixelMask {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> kept;  // 1 = counts, 0 = is unknown

    bool empty() const { return kept.empty(); }
};

struct MaskConfig {
    bool inverted = false;  // 0 counts, what is not 0 is unknown
    bool alpha = true;      // what is transparent in the left picture itself is unknown as well
};

struct ConfidenceConfig {
    // What is below is unknown. Integers are shares of the largest that their type holds (255, 65535), or of
    // 2 where none is above 2, as with ARKit's levels 0, 1, 2; floats are compared as they are.
    double threshold = 0.5;
    std::string key = {};  // array of an NPZ, channel of an EXR; empty = the only one, or the usual names
};

// Any image or map that the readers read; a pixel counts where one of its channels is not 0 (NaN is 0)
// and it is not transparent.
// Palettes count by their colours. Throws Error(input) as read_image() does, and where no pixel counts.
PixelMask read_mask(const std::filesystem::path& path, const MaskConfig& config,
                    const ReaderLimits& limits = {});

// Any format that read_disparity_map() reads. NaN is below every threshold. Throws likewise.
PixelMask read_confidence(const std::filesystem::path& path, const ConfidenceConfig& config,
                          const ReaderLimits& limits = {});

// The same of samples that were read already, of confidences one channel; errors name `path`.
PixelMask mask_of(const codec::Raster& raster, const std::filesystem::path& path, const MaskConfig& config);
PixelMask confidence_of(const codec::Raster& raster, const std::filesystem::path& path,
                        const ConfidenceConfig& config);

// The same view at another size: each pixel takes what lies under its centre.
PixelMask resampled(const PixelMask& mask, int width, int height);

}  // namespace hexrelief::readers
