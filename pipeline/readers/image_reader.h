// Reads images.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "pipeline/data/image.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {
namespace codec {

// Linear light, as OpenEXR files hold it, or samples that are encoded as sRGB's already.
enum class FloatColors { linear, encoded };

// Returns a raster of float colours with 8 bits, as sRGB: samples of 0 to 1 become 0 to 255, those beyond are
// clipped, and NaN becomes 0. Throws Error(input) if more than half of the samples are above 1, which another
// scale means.
Raster to_bytes(const Raster& colors, FloatColors kind, const std::filesystem::path& path);

}  // namespace codec

// Longer profiles are ignored; those of cameras and screens have some hundred bytes.
inline constexpr std::size_t kLongestProfile = 4 << 20;

// Converts the samples from the profile's colours to sRGB, relative to its white, and clips what sRGB does
// not reach. The image stays as it is if the profile is that of sRGB, of other colours than the image's (grey
// or RGB), malformed, or empty.
void to_srgb(Image& image, const std::vector<std::uint8_t>& profile);

// Reads a PNG, PPM/PGM (binary P5/P6), JPEG, TIFF, WebP, BMP or HEIC image, recognised by its content, not
// its name; 8 or 16 bit (16 is rounded to 8: (v * 255 + 32767) / 65535), grey or colour, palettes expanded,
// CMYK converted. Float colours are converted by to_bytes(): TIFF's are sRGB, OpenEXR's linear
// light. Grey gives 1 channel, colour 3. Alpha is kept if it is below half at some pixel. Pixels are as
// stored: upright() (exif.h) turns them. Colours are converted to sRGB by the file's ICC profile
//; without one, and whatever a PNG says of gamma, samples are sRGB. EXR and BMP have none.
// The first of several pages is read. Throws Error(input) if the file is missing, malformed or truncated, has
// a zero side or more pixels than the limits allow; never allocates more than a valid header within the
// limits requires.
Image read_image(const std::filesystem::path& path, const ReaderLimits& limits = {});
// Returns the codec that reads the image. Throws Error(input) for other files.
const codec::Codec& require_image_codec(const std::filesystem::path& path);
// As read_image(), for samples of an image or of a part of it that have been read
// already; errors name `path`.
Image image_of(codec::Raster raster, const std::filesystem::path& path);

}  // namespace hexrelief::readers
