// Applies masks and confidences to maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

// A mask or confidences, from a file or from an array; empty = none.
struct MaskSource {
    std::filesystem::path file;
    readers::PixelMask array = {};

    // Returns the name for messages.
    std::filesystem::path name(const char* in_memory) const {
        return file.empty() ? std::filesystem::path(in_memory) : file;
    }
};

// Sets values that the mask does not keep to unknown (+infinity). The values are those of a map of the mask's
// size; an empty mask keeps all.
void hide(std::vector<float>& values, const readers::PixelMask& mask);
// Hides the same pixels of a map, and sets the origins of its unknown pixels, if it has origins, to unknown.
void hide(DisparityMap& map, const readers::PixelMask& mask);

// Returns the mask of the image's opaque pixels; empty if it has no alpha. Throws Error(input) if
// no pixel is opaque.
readers::PixelMask opaque_part(const Image& image);

// Returns the mask of the pixels that both masks keep. An empty mask keeps all.
readers::PixelMask both(readers::PixelMask a, const readers::PixelMask& b);

// Returns the share of pixels with this value, in percent with one decimal.
std::string percent_text(const readers::PixelMask& mask, std::uint8_t value);

}  // namespace hexrelief::job
