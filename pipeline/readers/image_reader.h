// Reads the left and right images.
#pragma once

#include <filesystem>

#include "pipeline/data/image.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

// Reads a PNG, PPM/PGM (binary P5/P6), JPEG, TIFF, WebP or HEIC image, recognised by its content, not its
// name; 8 or 16 bit (16 is rounded to 8: (v * 255 + 32767) / 65535), grey or colour, palettes expanded, CMYK
// converted. Alpha is kept where some pixel's is below half. Grey gives 1 channel, colour 3. EXIF or TIFF
// orientation is ignored: calibrations and disparity maps belong to the pixels as stored. Colour profiles and
// gamma are ignored: samples are taken as sRGB. Of several pages the first is read. Throws Error(input) where
// the file is missing, malformed, truncated, has a zero side or more pixels than the limits allow; never
// allocates more than what a valid header within them asks for.
Image read_image(const std::filesystem::path& path, const ReaderLimits& limits = {});
// The same of samples that were read already, be they a part; errors name `path`.
Image image_of(codec::Raster raster, const std::filesystem::path& path);

}  // namespace hexrelief::readers
