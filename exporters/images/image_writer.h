// Image files: textures, stage pictures, float maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::exporters {

// All take images of 1 (grey) or 3 (sRGB) channels and throw Error(output) where the format cannot hold the
// image: WebP ends at 16383 px a side, JPEG at 65500, PNG at 2^31 - 1.
std::vector<std::uint8_t> encode_png(const Image& image);
std::vector<std::uint8_t> encode_jpeg(const Image& image, int quality);  // 1..100; 4:4:4, baseline, sRGB
std::vector<std::uint8_t> encode_webp(const Image& image, int quality);  // 1..100; lossy, always in colour
// One channel, float32 little endian, bottom row first; values row-major top row first.
std::vector<std::uint8_t> encode_pfm(int width, int height, const std::vector<float>& values);

// Both write whole files or none and throw Error(output) naming the path and the system's reason.
void write_png(const std::filesystem::path& path, const Image& image);
void write_pfm(const std::filesystem::path& path, int width, int height, const std::vector<float>& values);

}  // namespace hexrelief::exporters
