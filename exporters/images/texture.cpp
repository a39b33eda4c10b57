#include "exporters/images/texture.h"

#include <algorithm>
#include <cmath>

#include "exporters/images/image_writer.h"
#include "exporters/images/jpeg_blocks.h"
#include "exporters/images/picture_file.h"
#include "exporters/images/resize.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::exporters {
namespace {

// Margin beyond the outermost texture coordinates, so that linear filtering and a first level of mipmaps
// find the picture there.
constexpr int kCropMargin_px = 2;

PixelRect used_part(const std::vector<Vec2f>& texcoords, const Image& image) {
    Vec2f low = texcoords[0], high = low;
    for (const Vec2f& t : texcoords) {
        low = {std::min(low.x, t.x), std::min(low.y, t.y)};
        high = {std::max(high.x, t.x), std::max(high.y, t.y)};
    }
    const auto floor_px = [](float t, int size) {
        return std::clamp(static_cast<int>(std::floor(t * size)) - kCropMargin_px, 0, size - 1);
    };
    const auto ceil_px = [](float t, int size, int least) {
        return std::clamp(static_cast<int>(std::ceil(t * size)) + kCropMargin_px, least + 1, size);
    };
    const int left = floor_px(low.x, image.width), top = floor_px(low.y, image.height);
    return {left, top, ceil_px(high.x, image.width, left) - left, ceil_px(high.y, image.height, top) - top};
}

// Returns the part from the blocks of a JPEG file on that it begins in.
PixelRect from_blocks(const PixelRect& part) {
    const int left = part.x % kJpegBlock_px, top = part.y % kJpegBlock_px;
    return {part.x - left, part.y - top, part.width + left, part.height + top};
}

// Returns the length of a side after the part's longest side is limited to max_px.
int capped(int side, const PixelRect& part, int max_px) {
    const int longest = std::max(part.width, part.height);
    if (max_px <= 0 || longest <= max_px) return side;
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(side) * max_px / longest)));
}

// A texture that keeps what the file that it comes from has is the photograph itself, for up to so many times
// the bytes of one encoded anew: what is lost comes back at no quality.
constexpr double kWorthOfKept = 4. / 3;

bool is_jpeg(const std::vector<std::uint8_t>* file) {
    return file && image_type(*file) == "image/jpeg";
}

// Encodes a part of a picture at a quality, or as the JPEG file was that it comes from if that is smaller, or
// worth it.
std::vector<std::uint8_t> encode_small_jpeg(const Scene& scene, const Image& picture, const PixelRect& part,
                                            int quality) {
    JpegOfBlocks as_file;
    auto keeping = start_work(scene.threads, [&] {
        if (is_jpeg(scene.texture_file))
            as_file = encode_jpeg_as(*scene.texture_file, picture, part, scene.threads);
    });
    std::vector<std::uint8_t> anew = encode_jpeg(picture, part, quality, scene.threads);
    keeping.get();
    const double most = (as_file.keeps_blocks ? kWorthOfKept : 1) * static_cast<double>(anew.size());
    return as_file.bytes.empty() || static_cast<double>(as_file.bytes.size()) > most ? anew : as_file.bytes;
}

const char* extension_of_type(const std::string& mime_type) {
    return mime_type == "image/png" ? ".png" : mime_type == "image/webp" ? ".webp" : ".jpg";
}

// Returns the texture of a picture's PNG or WebP file with exactly its pixels, if that is worth more than the
// one encoded anew.
EncodedTexture keep_pixels(EncodedTexture anew, const Scene& scene, const TexturedMesh& mesh,
                           TextureFormat format) {
    if (!scene.texture_file || is_jpeg(scene.texture_file)) return anew;
    const std::string type = image_type(*scene.texture_file);
    const double worth = format == TextureFormat::png ? 1 : kWorthOfKept;
    const auto is_worth_it = [&](const std::vector<std::uint8_t>& bytes) {
        return !bytes.empty() && static_cast<double>(bytes.size()) <= worth * anew.bytes.size();
    };
    if (!may_keep(format, type) || !is_worth_it(*scene.texture_file)) return anew;
    const Image texture = texture_of(*scene.texture, mesh);
    std::vector<std::uint8_t> kept = bare_file(*scene.texture_file, texture);
    if (kept.empty() && type != anew.mime_type) kept = encode_png(texture);
    return is_worth_it(kept) ? EncodedTexture{std::move(kept), type} : std::move(anew);
}

EncodedTexture encode_anew(const Scene& scene, const TexturedMesh& mesh, const ExportConfig& config) {
    const Image& picture = *scene.texture;
    const bool is_scaled = mesh.width_px != mesh.part.width || mesh.height_px != mesh.part.height;
    const bool is_whole =
        !is_scaled && mesh.part.width == picture.width && mesh.part.height == picture.height;
    if (config.texture == TextureFormat::jpeg && !is_scaled)
        return {encode_small_jpeg(scene, picture, mesh.part, config.texture_quality), "image/jpeg"};
    const Image part = is_whole ? Image{} : texture_of(picture, mesh);
    const Image& texture = is_whole ? picture : part;
    switch (config.texture) {
        case TextureFormat::png:
            return {encode_png(texture), "image/png"};
        case TextureFormat::webp:
            return {encode_webp(texture, config.texture_quality), "image/webp"};
        default:
            return {encode_small_jpeg(scene, texture, {0, 0, texture.width, texture.height},
                                      config.texture_quality),
                    "image/jpeg"};
    }
}

}  // namespace

std::filesystem::path texture_path(const std::filesystem::path& path, const std::string& mime_type) {
    std::filesystem::path name = path.stem();
    name += std::string("_texture") + extension_of_type(mime_type);
    return path.parent_path() / name;
}

std::vector<std::string> texture_types(TextureFormat format) {
    switch (format) {
        case TextureFormat::none:
            return {};
        case TextureFormat::jpeg:
            return {"image/jpeg", "image/png"};
        case TextureFormat::png:
            return {"image/png"};
        case TextureFormat::webp:
            return {"image/webp"};
    }
    return {};
}

bool may_keep(TextureFormat format, const std::string& file_type) {
    return std::ranges::count(texture_types(format), file_type) > 0;
}

TexturedMesh untextured_mesh(const Scene& scene, const ExportConfig& config) {
    TexturedMesh out;
    out.grid_step_m = scene.grid_step_m;
    out.mesh = *scene.mesh;
    if (config.normals == NormalsKind::never) out.mesh.normals.clear();
    if (!config.texcoords || !scene.texture) {
        out.mesh.texcoords.clear();
        return out;
    }
    out.width_px = scene.texture->width;
    out.height_px = scene.texture->height;
    return out;
}

SurfaceMesh left_view_of(const SurfaceMesh& mesh, int width, int height) {
    SurfaceMesh left = mesh;
    if (mesh.parts.empty()) return left;
    const std::size_t count = mesh.left_vertices();
    for (std::vector<Vec2f>* values : {&left.texcoords, &left.image_points}) values->resize(count);
    for (std::vector<Vec3f>* values : {&left.positions, &left.normals}) values->resize(count);
    left.disparities.resize(count);
    left.provenance.clear();
    left.triangles.resize(mesh.left_triangles());
    left.parts.clear();
    const float columns = static_cast<float>(width), rows = static_cast<float>(height);
    for (std::size_t i = 0; i < count; ++i)
        left.texcoords[i] = {std::clamp(left.image_points[i].x / columns, 0.0f, 1.0f),
                             std::clamp(left.image_points[i].y / rows, 0.0f, 1.0f)};
    return left;
}

std::vector<TexturedMesh> textured_levels(const Scene& scene, const ExportConfig& config) {
    std::vector<TexturedMesh> levels = {untextured_mesh(scene, config)};
    for (const SurfaceMesh* mesh : scene.coarser) {
        Scene level = scene;
        level.mesh = mesh;
        levels.push_back(untextured_mesh(level, config));
    }
    if (levels[0].mesh.texcoords.empty() || config.texture == TextureFormat::none) return levels;
    const Image& image = *scene.texture;
    PixelRect part{0, 0, image.width, image.height};
    if (config.texture_crop) {
        std::vector<Vec2f> all;
        for (const TexturedMesh& level : levels)
            all.insert(all.end(), level.mesh.texcoords.begin(), level.mesh.texcoords.end());
        part = used_part(all, image);
        if (is_jpeg(scene.texture_file) && config.texture == TextureFormat::jpeg) part = from_blocks(part);
    }
    for (TexturedMesh& level : levels) {
        level.textured = true;
        level.part = part;
        level.width_px = capped(part.width, part, config.texture_max_px);
        level.height_px = capped(part.height, part, config.texture_max_px);
        for (Vec2f& t : level.mesh.texcoords)
            t = {static_cast<float>((static_cast<double>(t.x) * image.width - part.x) / part.width),
                 static_cast<float>((static_cast<double>(t.y) * image.height - part.y) / part.height)};
    }
    return levels;
}

TexturedMesh textured_mesh(const Scene& scene, const ExportConfig& config) {
    return std::move(textured_levels(scene, config)[0]);
}

Image texture_of(const Image& picture, const TexturedMesh& mesh) {
    Image texture = cropped(picture, mesh.part);
    if (texture.width == mesh.width_px && texture.height == mesh.height_px) return texture;
    return resized(texture, mesh.width_px, mesh.height_px);
}

EncodedTexture encode_texture(const Scene& scene, const TexturedMesh& mesh, const ExportConfig& config) {
    return keep_pixels(encode_anew(scene, mesh, config), scene, mesh, config.texture);
}

ArchivedMesh archived_mesh(const Scene& scene, ExportConfig config, const std::string& stem) {
    if (config.texture == TextureFormat::webp) config.texture = TextureFormat::jpeg;
    ArchivedMesh out{textured_mesh(scene, config), {}, {}};
    if (!out.textured.textured) return out;
    out.texture = encode_texture(scene, out.textured, config);
    out.texture_name = stem + extension_of_type(out.texture.mime_type);
    return out;
}

}  // namespace hexrelief::exporters
