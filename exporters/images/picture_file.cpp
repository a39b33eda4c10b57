#include "exporters/images/picture_file.h"

#include <png.h>
#include <webp/decode.h>

#include <cstring>

namespace hexrelief::exporters {
namespace {

using Bytes = std::vector<std::uint8_t>;

bool has_at(const Bytes& file, std::size_t place, const char* text) {
    const std::size_t length = std::strlen(text);
    return file.size() >= place + length && std::memcmp(file.data() + place, text, length) == 0;
}

std::size_t u32_big(const Bytes& file, std::size_t place) {
    std::size_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | file[place + i];
    return value;
}

std::size_t u32_little(const Bytes& file, std::size_t place) {
    std::size_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | file[place + i];
    return value;
}

constexpr std::size_t kPngSignature = 8;

// Returns a PNG file's critical chunks, whose names begin with a capital letter; none if the last one is
// missing. What follows it is no part of the picture.
Bytes critical_chunks(const Bytes& file) {
    constexpr std::size_t kLengthAndName = 8, kChecksum = 4;
    Bytes bare(file.begin(), file.begin() + kPngSignature);
    for (std::size_t at = kPngSignature; file.size() - at >= kLengthAndName + kChecksum;) {
        const std::size_t length = u32_big(file, at);
        if (length > file.size() - at - kLengthAndName - kChecksum) return {};
        const std::size_t end = at + kLengthAndName + length + kChecksum;
        if (file[at + 4] < 'a') bare.insert(bare.end(), file.begin() + at, file.begin() + end);
        if (has_at(file, at + 4, "IEND")) return bare;
        at = end;
    }
    return {};
}

bool is_png_of(const Bytes& bare, const Image& picture) {
    constexpr std::size_t kBits = kPngSignature + 16, kColourType = kBits + 1;
    if (bare.size() <= kColourType || bare[kBits] > 8 || bare[kColourType] & PNG_COLOR_MASK_ALPHA)
        return false;
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    Bytes pixels;
    const bool is_read = [&] {
        if (!png_image_begin_read_from_memory(&image, bare.data(), bare.size())) return false;
        if (image.width != static_cast<unsigned>(picture.width) ||
            image.height != static_cast<unsigned>(picture.height))
            return false;
        image.format = picture.channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
        pixels.resize(picture.pixels.size());
        // A warning tells of bytes that are none of the picture's.
        return png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) != 0 &&
               image.warning_or_error == 0;
    }();
    png_image_free(&image);
    return is_read && pixels == picture.pixels;
}

// Returns a WebP file's picture in the simple layout, which holds nothing else; no bytes if it has none.
Bytes simple_webp(const Bytes& file) {
    constexpr std::size_t kFileHeader = 12, kChunkHeader = 8;
    for (std::size_t at = kFileHeader; at + kChunkHeader <= file.size();) {
        const std::size_t length = u32_little(file, at + 4), padded = length + length % 2;
        if (padded > file.size() - at - kChunkHeader) return {};
        if (has_at(file, at, "VP8 ") || has_at(file, at, "VP8L")) {
            Bytes bare(file.begin(), file.begin() + kFileHeader);
            bare.insert(bare.end(), file.begin() + at, file.begin() + at + kChunkHeader + padded);
            for (std::size_t i = 0; i < 4; ++i)
                bare[4 + i] = static_cast<std::uint8_t>((bare.size() - kChunkHeader) >> (8 * i));
            return bare;
        }
        at += kChunkHeader + padded;
    }
    return {};
}

bool is_webp_of(const Bytes& bare, const Image& picture) {
    WebPBitstreamFeatures features{};
    if (picture.channels != 3 || WebPGetFeatures(bare.data(), bare.size(), &features) != VP8_STATUS_OK ||
        features.has_alpha || features.width != picture.width || features.height != picture.height)
        return false;
    Bytes pixels(picture.pixels.size());
    return WebPDecodeRGBInto(bare.data(), bare.size(), pixels.data(), pixels.size(), 3 * picture.width) &&
           pixels == picture.pixels;
}

}  // namespace

std::string image_type(const Bytes& file) {
    if (has_at(file, 0, "\xff\xd8")) return "image/jpeg";
    if (has_at(file, 0, "\x89PNG\r\n\x1a\n")) return "image/png";
    if (has_at(file, 0, "RIFF") && has_at(file, 8, "WEBP")) return "image/webp";
    return {};
}

std::vector<std::uint8_t> bare_file(const Bytes& file, const Image& picture) {
    const std::string type = image_type(file);
    const bool is_png = type == "image/png";
    if (!is_png && type != "image/webp") return {};
    Bytes bare = is_png ? critical_chunks(file) : simple_webp(file);
    const bool is_same = is_png ? is_png_of(bare, picture) : is_webp_of(bare, picture);
    return is_same ? bare : Bytes{};
}

}  // namespace hexrelief::exporters
