// Tests that a texture is the PNG or WebP file that it comes from if that is smaller.
#include "exporters/images/picture_file.h"

#include <gtest/gtest.h>
#include <png.h>
#include <webp/encode.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "exporters/images/image_writer.h"
#include "exporters/images/texture.h"
#include "tests/exporters/sample_scene.h"

namespace hexrelief::exporters {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kPalette[2][3] = {{20, 60, 200}, {250, 240, 10}};

// Two colours without any order: many bytes as JPEG, an eighth of a byte a pixel as PNG.
Image two_colours(int width, int height) {
    Image image{width, height, 3, {}};
    std::uint32_t state = 1;
    for (int i = 0; i < width * height; ++i) {
        state = state * 1664525u + 1013904223u;
        const auto& colour = kPalette[state >> 31];
        image.pixels.insert(image.pixels.end(), colour, colour + 3);
    }
    return image;
}

// With a palette, as encode_png() never writes, and a comment.
Bytes palette_png(const Image& image) {
    Bytes indices;
    for (std::size_t i = 0; i < image.pixels.size(); i += 3)
        indices.push_back(image.pixels[i] == kPalette[1][0]);
    png_image file{};
    file.version = PNG_IMAGE_VERSION;
    file.width = static_cast<unsigned>(image.width), file.height = static_cast<unsigned>(image.height);
    file.format = PNG_FORMAT_RGB_COLORMAP;
    file.colormap_entries = 2;
    Bytes bytes(1 << 16);
    png_alloc_size_t size = bytes.size();
    EXPECT_TRUE(png_image_write_to_memory(&file, bytes.data(), &size, 0, indices.data(), 0, kPalette));
    bytes.resize(size);
    const std::string comment("\0\0\0\4tEXtk\0vvcrc.", 16);
    constexpr int kEndOfHeader = 33;
    bytes.insert(bytes.begin() + kEndOfHeader, comment.begin(), comment.end());
    return bytes;
}

// In the extended layout, with EXIF data.
Bytes lossless_webp(const Image& image) {
    std::uint8_t* encoded = nullptr;
    const std::size_t size =
        WebPEncodeLosslessRGB(image.pixels.data(), image.width, image.height, 3 * image.width, &encoded);
    std::string body = std::string("VP8X\12\0\0\0\10\0\0\0", 12);
    for (const int side : {image.width, image.height}) body += {static_cast<char>(side - 1), 0, 0};
    body.append(encoded + 12, encoded + size).append("EXIF\2\0\0\0MM", 10);
    WebPFree(encoded);
    std::string file = "RIFF";
    for (int shift = 0; shift < 32; shift += 8) file += static_cast<char>((body.size() + 4) >> shift);
    file += "WEBP" + body;
    return {file.begin(), file.end()};
}

bool holds(const std::string& text, const Bytes& bytes) {
    return !bytes.empty() &&
           std::search(text.begin(), text.end(), bytes.begin(), bytes.end(), [](char a, std::uint8_t b) {
               return static_cast<std::uint8_t>(a) == b;
           }) != text.end();
}

bool holds(const Bytes& bytes, const char* text) {
    return std::string(bytes.begin(), bytes.end()).find(text) != std::string::npos;
}

class PictureFile : public testing::Test {
  protected:
    // Returns the texture of the mesh that shows the whole picture.
    EncodedTexture texture() const { return encode_texture(scene_, textured_mesh(scene_, config_), config_); }

    const Image picture_ = two_colours(64, 48);
    const Bytes png_ = palette_png(picture_), webp_ = lossless_webp(picture_);
    SurfaceMesh mesh_ = sample_mesh(8, 6);
    Scene scene_{&mesh_, &picture_, kGenerator, ""};
    ExportConfig config_;
};

TEST_F(PictureFile, LosesItsMetadataAlone) {
    for (const auto& [file, metadata] : {std::pair{png_, "tEXt"}, {webp_, "EXIF"}}) {
        const Bytes bare = bare_file(file, picture_);
        ASSERT_FALSE(bare.empty()) << metadata;
        EXPECT_EQ(image_type(bare), image_type(file));
        EXPECT_LT(bare.size(), file.size());
        EXPECT_TRUE(holds(file, metadata));
        EXPECT_FALSE(holds(bare, metadata));
        EXPECT_EQ(bare_file(bare, picture_), bare);
    }
}

TEST_F(PictureFile, OfAnotherPictureGivesNothing) {
    Image other = picture_;
    ++other.pixels.back();
    // A WebP's metadata follow its picture, a PNG ends with a chunk of its own.
    for (const auto& [file, metadata] : {std::pair<Bytes, std::size_t>{png_, 0}, {webp_, 40}}) {
        EXPECT_TRUE(bare_file(file, other).empty());
        EXPECT_TRUE(bare_file(file, two_colours(64, 47)).empty());
        for (std::size_t length = 0; length + metadata < file.size(); ++length)
            EXPECT_TRUE(bare_file(Bytes(file.begin(), file.begin() + length), picture_).empty()) << length;
    }
    EXPECT_TRUE(bare_file(encode_jpeg(picture_, 90), picture_).empty());
}

TEST_F(PictureFile, EndsWhereThePngDoes) {
    const Bytes bare = bare_file(png_, picture_);
    Bytes longer = bare;  // by a chunk with a capital letter, and a byte
    for (const char byte : std::string_view("\0\0\0\4ABCDtextsum4.", 17)) longer.push_back(byte);
    EXPECT_EQ(bare_file(longer, picture_), bare);
}

TEST_F(PictureFile, IsTheTextureOfEveryFormat) {
    scene_.texture_file = &png_;
    const Bytes bare = bare_file(png_, picture_);
    for (const MeshFormat* format : formats_of_files()) {
        if (format->colours != ColourStorage::texture) continue;
        for (const Compression compression : {Compression::none, Compression::draco}) {
            const TemporaryFolder folder;
            config_.compression = compression;
            bool is_kept = false, is_named = false;
            for (const auto& path :
                 export_scene(scene_, config_, folder / ("a" + std::string(format->extension)))) {
                is_kept = is_kept || holds(contents(path), bare);
                is_named = is_named || contents(path).find("png") != std::string::npos;
                EXPECT_NE(path.extension(), ".jpg");
            }
            EXPECT_TRUE(is_kept) << format->name();
            EXPECT_TRUE(is_named) << format->name();
        }
    }
}

TEST_F(PictureFile, IsEncodedAnewIfThatIsMuchSmaller) {
    scene_.texture_file = &png_;
    config_.texture_quality = 1;
    const Image flat{64, 48, 3, Bytes(64 * 48 * 3, 100)};
    EXPECT_EQ(texture().bytes, bare_file(png_, picture_));
    scene_.texture = &flat;
    EXPECT_EQ(texture().bytes, encode_jpeg(flat, 1));
}

TEST_F(PictureFile, ItsPartsAreLosslessAsWell) {
    scene_.texture_file = &png_;
    for (Vec2f& t : mesh_.texcoords) t = {t.x / 2, t.y / 2};
    const EncodedTexture part = texture();
    EXPECT_EQ(part.mime_type, "image/png");
    EXPECT_EQ(part.bytes, encode_png(texture_of(picture_, textured_mesh(scene_, config_))));
}

TEST_F(PictureFile, KeepsItsTypeWhereOneIsAskedFor) {
    for (const auto& [format, file] : {std::pair{TextureFormat::png, &png_}, {TextureFormat::webp, &webp_}}) {
        config_.texture = format;
        scene_.texture_file = file;
        EXPECT_EQ(texture().bytes, bare_file(*file, picture_));
    }
    scene_.texture_file = &png_;
    EXPECT_EQ(texture().mime_type, "image/webp") << "which was asked for";
    config_.texture = TextureFormat::jpeg;
    scene_.texture_file = &webp_;
    EXPECT_EQ(texture().mime_type, "image/jpeg") << "not every reader of glTF knows WebP";
}

}  // namespace
}  // namespace hexrelief::exporters
