// Writes image files: textures, stage pictures, float maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "pipeline/data/crop.h"
#include "pipeline/data/image.h"

namespace hexrelief::exporters {

// Encode images of 1 (grey) or 3 (sRGB) channels. Throw Error(output) if the format cannot hold the image:
// WebP ends at 16383 px a side, JPEG at 65500, PNG at 2^31 - 1.
std::vector<std::uint8_t> encode_png(const Image& image);
std::vector<std::uint8_t> encode_jpeg(const Image& image, int quality);  // 1..100; 4:4:4, baseline, sRGB
// Encodes a part of the image; the bytes do not depend on the number of threads.
std::vector<std::uint8_t> encode_jpeg(const Image& image, const PixelRect& part, int quality, int threads);
std::vector<std::uint8_t> encode_webp(const Image& image, int quality);  // 1..100; lossy, always in colour
// Encodes a PFM of one channel: float32 little endian, bottom row first. `values` is
// row-major, top row first.
std::vector<std::uint8_t> encode_pfm(int width, int height, const std::vector<float>& values);
// Encodes an OpenEXR of one channel, uncompressed float32: Z, as compositors name depths. `values` as above.
std::vector<std::uint8_t> encode_exr(int width, int height, const std::vector<float>& values);

// Write whole files or none. Throw Error(output) naming the path and the system's reason.
void write_png(const std::filesystem::path& path, const Image& image);
void write_pfm(const std::filesystem::path& path, int width, int height, const std::vector<float>& values);

}  // namespace hexrelief::exporters
