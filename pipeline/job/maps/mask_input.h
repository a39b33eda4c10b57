// Masks and confidences as the maps take them.
#pragma once

#include <vector>

#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief {

// Makes unknown (+infinity) what the mask does not keep; the values are those of a map of the mask's size.
void hide(std::vector<float>& values, const PixelMask& mask);

// What both keep. Either may be empty, which keeps all.
PixelMask both(PixelMask a, const PixelMask& b);

}  // namespace hexrelief
