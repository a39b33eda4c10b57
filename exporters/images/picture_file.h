// The files that pictures were read from, as textures.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief::exporters {

// Returns "image/jpeg", "image/png" or "image/webp" by a file's first 12 bytes; empty = another type.
std::string image_type(const std::vector<std::uint8_t>& file);

// Returns a PNG or WebP file without its metadata and colour profile. Returns no bytes unless its pixels are
// then the picture's, of 8 bits at most and without an alpha channel.
std::vector<std::uint8_t> bare_file(const std::vector<std::uint8_t>& file, const Image& picture);

}  // namespace hexrelief::exporters
