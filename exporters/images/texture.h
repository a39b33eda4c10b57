// The texture as an image file in memory, shared by glTF and OBJ, and the mesh that it lies on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/core/scene.h"
#include "pipeline/data/crop.h"

namespace hexrelief::exporters {

struct EncodedTexture {
    std::vector<std::uint8_t> bytes;
    std::string mime_type;  // "image/jpeg", "image/png" or "image/webp"
};

// The texture file beside path: "<stem>_texture.jpg", ".png" or ".webp". The suffix keeps `-o photo.obj` from
// overwriting the photo.png that it was made from.
std::filesystem::path texture_path(const std::filesystem::path& path, const ExportConfig& config);

// A scene's mesh with the configured attributes, and where its texture lies in the scene's picture: cropped
// to what the mesh and all other levels of detail show, and scaled down to the largest size. The texture
// coordinates are those of this texture.
struct TexturedMesh {
    SurfaceMesh mesh;
    bool textured = false;            // whether the document has a texture; all levels share one
    PixelRect part;                   // of the picture that is the texture
    int width_px = 1, height_px = 1;  // of the image that the texture coordinates mean, written or not
    double grid_step_m = 0;           // as the scene's
};

TexturedMesh textured_mesh(const Scene& scene, const ExportConfig& config);
// All levels of detail, the finest first.
std::vector<TexturedMesh> textured_levels(const Scene& scene, const ExportConfig& config);

// The same for formats without a texture file: their texture coordinates belong to the whole given image.
TexturedMesh untextured_mesh(const Scene& scene, const ExportConfig& config);

// The texture that lies on a textured mesh, of the scene's picture.
Image texture_of(const Image& picture, const TexturedMesh& mesh);
EncodedTexture encode_texture(const Image& picture, const TexturedMesh& mesh, const ExportConfig& config);

}  // namespace hexrelief::exporters
