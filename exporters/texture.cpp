#include "exporters/texture.h"

#include "exporters/image_writer.h"

namespace hexrelief {

EncodedTexture encode_texture(const Image& image, const ExportConfig& config) {
    if (config.texture_format == TextureFormat::png) return {encode_png(image), "image/png"};
    return {encode_jpeg(image, config.jpeg_quality), "image/jpeg"};
}

std::filesystem::path texture_path(const std::filesystem::path& path, const ExportConfig& config) {
    std::filesystem::path name = path.stem();
    name += config.texture_format == TextureFormat::png ? "_texture.png" : "_texture.jpg";
    return path.parent_path() / name;
}

}  // namespace hexrelief
