// Pictures of floats as pictures of bytes.
#pragma once

#include <filesystem>

#include "pipeline/readers/decoded_raster.h"

namespace hexrelief::readers::codec {

// Linear light, as OpenEXR files hold it, or samples that are encoded as sRGB's already.
enum class FloatColors { linear, encoded };

// Returns a raster of float colours with 8 bits, as sRGB: samples of 0 to 1 become 0 to 255, those beyond are
// clipped, and NaN becomes 0. Throws Error(input) if more than half of the samples are above 1, which another
// scale means.
Raster to_bytes(const Raster& colors, FloatColors kind, const std::filesystem::path& path);

}  // namespace hexrelief::readers::codec
