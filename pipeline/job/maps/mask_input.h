// Masks and confidences as the maps take them.
#pragma once

#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

// Makes unknown (+infinity) what the mask does not keep; the values are those of a map of the mask's size.
void hide(std::vector<float>& values, const readers::PixelMask& mask);
// The same of a map, whose origins, where it has some, then say so.
void hide(DisparityMap& map, const readers::PixelMask& mask);

// What is opaque in the image; empty where all is. Throws Error(input) where nothing is.
readers::PixelMask opaque_part(const Image& image);

// What both keep. Either may be empty, which keeps all.
readers::PixelMask both(readers::PixelMask a, const readers::PixelMask& b);

}  // namespace hexrelief::job
