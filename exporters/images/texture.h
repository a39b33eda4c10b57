// The texture as an image file in memory, shared by glTF and OBJ, and the mesh that it is mapped to.
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

// Returns the path of a texture file of a type beside `path`: "<stem>_texture.jpg", ".png" or ".webp". The
// suffix keeps `-o photo.obj` from overwriting the photo.png that it was made from.
std::filesystem::path texture_path(const std::filesystem::path& path, const std::string& mime_type);
// Returns the types that encode_texture() may choose.
std::vector<std::string> texture_types(TextureFormat format);
// True if a texture may keep something of a picture's file of that type (image_type()).
bool may_keep(TextureFormat format, const std::string& file_type);

// A scene's mesh with the configured attributes, and the part of the scene's picture that is its texture:
// cropped to what the mesh and all other levels of detail show, and scaled down to the largest size. The
// texture coordinates are those of this texture.
struct TexturedMesh {
    SurfaceMesh mesh;
    bool textured = false;  // the document has a texture; all levels share it
    PixelRect part;         // part of the picture that is the texture
    // Size of the image that the texture coordinates refer to, written or not.
    int width_px = 1, height_px = 1;
    double grid_step_m = 0;  // as in the scene
};

// Returns the finest level with its texture coordinates.
TexturedMesh textured_mesh(const Scene& scene, const ExportConfig& config);
// Returns all levels of detail with their texture coordinates, the finest first.
std::vector<TexturedMesh> textured_levels(const Scene& scene, const ExportConfig& config);

// Returns the part of a mesh that the left picture shows, with texture coordinates of that picture, which has
// width x height px: for formats that say how a picture is mapped but do not hold it.
SurfaceMesh left_view_of(const SurfaceMesh& mesh, int width, int height);

// Returns the mesh for formats without a texture file: texture coordinates refer to the whole given image.
TexturedMesh untextured_mesh(const Scene& scene, const ExportConfig& config);

// Returns the texture of a textured mesh, cut from the scene's picture.
Image texture_of(const Image& picture, const TexturedMesh& mesh);
// Encodes it. If scene.texture_file is a file of the same type, or a PNG in place of JPEG, it keeps what that
// file has for at most a third more bytes than the quality takes: a JPEG's blocks; a PNG's or WebP's pixels
// if the file as it lies, with metadata and all views, takes no more than that either. A JPEG of a JPEG takes
// no more bytes than if it were encoded as that file is.
EncodedTexture encode_texture(const Scene& scene, const TexturedMesh& mesh, const ExportConfig& config);

// The finest level and its texture for an archive's formats, none of which knows WebP.
struct ArchivedMesh {
    TexturedMesh textured;
    EncodedTexture texture;    // JPEG, in place of WebP, or PNG
    std::string texture_name;  // in the archive; empty = no texture
};
// stem: the name without its extension.
ArchivedMesh archived_mesh(const Scene& scene, ExportConfig config, const std::string& stem);

}  // namespace hexrelief::exporters
