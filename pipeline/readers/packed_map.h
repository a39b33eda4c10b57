// Maps whose numbers are spread over the red, green and blue of a picture.
#pragma once

#include <filesystem>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers::codec {

// Replaces a picture's colours by the numbers that they stand for. The path is for the message. Throws
// Error(input) for a raster without three channels of 8 bits.
void unpack(Raster& raster, Packing packing, const std::filesystem::path& path);

}  // namespace hexrelief::readers::codec
