// Image files: textures, stage pictures, float maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief {

std::vector<std::uint8_t> encode_png(const Image& image);
std::vector<std::uint8_t> encode_jpeg(const Image& image, int quality);  // 4:4:4, baseline, sRGB

void write_png(const std::filesystem::path& path, const Image& image);
// One channel, float32 little endian, bottom row first; values row-major top row first.
void write_pfm(const std::filesystem::path& path, int width, int height, const std::vector<float>& values);

}  // namespace hexrelief
