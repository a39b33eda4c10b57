// The texture as an image file in memory, shared by glTF and OBJ.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/exporter.h"

namespace hexrelief {

struct EncodedTexture {
    std::vector<std::uint8_t> bytes;
    std::string mime_type;  // "image/jpeg" or "image/png"
};

EncodedTexture encode_texture(const Image& image, const ExportConfig& config);

// The texture file beside path: "<stem>_texture.jpg" or ".png". The suffix keeps `-o photo.obj` from
// overwriting the photo.png that it was made from.
std::filesystem::path texture_path(const std::filesystem::path& path, const ExportConfig& config);

}  // namespace hexrelief
