// Reads Windows bitmaps (BMP): palettes, also as runs (RLE8, RLE4), and pixels of 16, 24 or 32 bits.
#include <algorithm>
#include <array>
#include <bit>

#include "pipeline/readers/codecs.h"

namespace hexrelief::readers::codec {
namespace {

constexpr std::size_t kFileHeader = 14;

std::uint32_t number(const std::vector<std::uint8_t>& bytes, std::size_t at, int count) {
    std::uint32_t value = 0;
    for (int i = 0; i < count && at + i < bytes.size(); ++i)
        value |= static_cast<std::uint32_t>(bytes[at + i]) << 8 * i;
    return value;
}

struct Bitmap {
    int width = 0, height = 0, bits = 0;
    bool is_top_first = false, is_in_runs = false;
    std::size_t offset = 0, row_bytes = 0;  // of the rows in the file
    std::array<std::uint32_t, 4> masks{};   // red, green, blue, alpha
    std::vector<std::array<std::uint8_t, 3>> palette{};

    bool is_grey() const {
        return bits <= 8 &&
               std::ranges::all_of(palette, [](const auto& c) { return c[0] == c[1] && c[0] == c[2]; });
    }
    int channels() const { return is_grey() ? 1 : masks[3] != 0 ? 4 : 3; }
};

[[noreturn]] void refuse_bitmap(const SourceFile& source, const std::string& what) {
    refuse(source.path, "malformed BMP: " + what + "; save it again, or as PNG");
}

void read_masks(const SourceFile& source, Bitmap& bitmap, std::uint32_t header, std::uint32_t compression) {
    constexpr std::uint32_t fields = 3, fields_with_alpha = 6;
    if (compression == 0) {
        bitmap.masks = bitmap.bits == 16 ? std::array<std::uint32_t, 4>{0x7c00, 0x3e0, 0x1f, 0}
                                         : std::array<std::uint32_t, 4>{0xff0000, 0xff00, 0xff, 0};
        return;
    }
    constexpr std::uint32_t header_of_os2 = 64;  // whose compressions are others
    constexpr std::uint32_t runs_of_8 = 1, runs_of_4 = 2;
    bitmap.is_in_runs = header != header_of_os2 && ((compression == runs_of_8 && bitmap.bits == 8) ||
                                                    (compression == runs_of_4 && bitmap.bits == 4));
    if (bitmap.is_in_runs) return;
    if ((compression != fields && compression != fields_with_alpha) || header == header_of_os2)
        refuse(source.path, "it is a compressed BMP; save it uncompressed, or as PNG");
    const bool has_alpha = header >= 56 || compression == fields_with_alpha;
    for (std::size_t i = 0; i < (has_alpha ? 4u : 3u); ++i)
        bitmap.masks[i] = number(source.bytes, kFileHeader + 40 + 4 * i, 4);
    for (std::size_t i = 0; i < 3; ++i)
        if (bitmap.masks[i] == 0) refuse_bitmap(source, "a colour has no bits");
}

void read_palette(const SourceFile& source, Bitmap& bitmap, std::uint32_t header, std::uint32_t colors) {
    const std::uint32_t most = 1u << bitmap.bits, entry = header == 12 ? 3 : 4;
    const std::uint32_t count = colors == 0 ? most : std::min(colors, most);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::size_t at = kFileHeader + header + entry * i;
        if (at + entry > source.bytes.size()) refuse_bitmap(source, "its palette is truncated");
        bitmap.palette.push_back({source.bytes[at + 2], source.bytes[at + 1], source.bytes[at]});
    }
}

Bitmap read_header(const SourceFile& source) {
    const auto& bytes = source.bytes;
    const std::uint32_t header = number(bytes, kFileHeader, 4);
    if (bytes.size() < kFileHeader + header) refuse_bitmap(source, "its header is truncated");
    const bool is_old = header == 12;
    Bitmap bitmap;
    // Old headers have two bytes without a sign.
    const auto side = [&](std::size_t old_at, std::size_t at) -> std::int64_t {
        if (is_old) return number(bytes, old_at, 2);
        return static_cast<std::int32_t>(number(bytes, at, 4));
    };
    const std::int64_t width = side(18, 18), height = side(20, 22);
    if (width < 0) refuse_bitmap(source, "its width is negative");
    check_size(source, static_cast<unsigned long long>(width),
               static_cast<unsigned long long>(height < 0 ? -height : height));
    bitmap.width = static_cast<int>(width);
    bitmap.height = static_cast<int>(height < 0 ? -height : height);
    bitmap.is_top_first = height < 0;
    bitmap.bits = static_cast<int>(number(bytes, is_old ? 24 : 28, 2));
    bitmap.offset = number(bytes, 10, 4);
    const std::array<int, 6> known{1, 4, 8, 16, 24, 32};
    if (std::ranges::find(known, bitmap.bits) == known.end())
        refuse_bitmap(source, "it has " + std::to_string(bitmap.bits) + " bits per pixel");
    bitmap.row_bytes = (static_cast<std::size_t>(bitmap.width) * bitmap.bits + 31) / 32 * 4;
    read_masks(source, bitmap, header, is_old ? 0 : number(bytes, 30, 4));
    if (bitmap.bits <= 8) {
        bitmap.masks[3] = 0;
        read_palette(source, bitmap, header, is_old ? 0 : number(bytes, 46, 4));
    }
    if (bitmap.is_in_runs) {
        // A run of 255 pixels takes two bytes.
        check_length(source, static_cast<unsigned long long>(bitmap.width) * bitmap.height, 128);
        return bitmap;
    }
    if (source.size() < bitmap.offset ||
        (source.size() - bitmap.offset) / bitmap.row_bytes < static_cast<std::uint64_t>(bitmap.height))
        refuse(source.path, "truncated or damaged: it ends before its last row; copy or save it again");
    return bitmap;
}

// Returns the bits of the mask as a number from 0 to 255, rounded.
std::uint8_t masked(std::uint32_t pixel, std::uint32_t mask) {
    const int shift = std::countr_zero(mask);
    const std::uint64_t most = mask >> shift, value = (pixel & mask) >> shift;
    return static_cast<std::uint8_t>((value * 255 + most / 2) / most);
}

// Returns the palette's indices of all pixels, row by row as in the file, a byte each. Pixels that the runs
// skip have the index 0.
std::vector<std::uint8_t> unpack_runs(const SourceFile& source, const Bitmap& bitmap) {
    const auto width = static_cast<std::size_t>(bitmap.width),
               height = static_cast<std::size_t>(bitmap.height);
    std::vector<std::uint8_t> indices(width * height);
    std::size_t at = bitmap.offset, x = 0, y = 0;
    const auto next = [&] {
        if (at >= source.bytes.size())
            refuse(source.path, "truncated or damaged: it ends before its last row; copy or save it again");
        return source.bytes[at++];
    };
    const auto put = [&](std::size_t count, const auto& index) {
        if (y >= height || count > width - std::min(x, width))
            refuse_bitmap(source, "a run leaves the picture");
        for (std::size_t i = 0; i < count; ++i, ++x) indices[y * width + x] = index(i);
    };
    // Two pixels of 4 bits take a byte.
    const auto half = [](std::uint8_t pair, std::size_t i) {
        return static_cast<std::uint8_t>(i % 2 == 0 ? pair >> 4 : pair & 15);
    };
    for (;;) {
        const std::uint8_t count = next(), value = next();
        if (count > 0) {
            put(count, [&](std::size_t i) { return bitmap.bits == 8 ? value : half(value, i); });
        } else if (value == 0) {  // the row's end
            x = 0;
            ++y;
        } else if (value == 1) {  // the picture's end
            return indices;
        } else if (value == 2) {  // a step to another pixel
            x += next();
            y += next();
        } else {  // pixels one by one, up to an even number of bytes
            std::uint8_t pair = 0;
            put(value, [&](std::size_t i) {
                if (bitmap.bits == 8 || i % 2 == 0) pair = next();
                return bitmap.bits == 8 ? pair : half(pair, i);
            });
            const std::size_t bytes = bitmap.bits == 8 ? value : (value + 1u) / 2;
            if (bytes % 2 == 1) next();
        }
    }
}

void append_row(const std::vector<std::uint8_t>& bytes, const SourceFile& source, const Bitmap& bitmap,
                std::size_t at, std::vector<std::uint8_t>& samples) {
    const int channels = bitmap.channels();
    for (int x = 0; x < bitmap.width; ++x) {
        if (bitmap.bits > 8) {
            const std::size_t pixel_bytes = bitmap.bits / 8;
            const std::uint32_t pixel = number(bytes, at + pixel_bytes * x, static_cast<int>(pixel_bytes));
            for (int c = 0; c < channels; ++c) samples.push_back(masked(pixel, bitmap.masks[c]));
            continue;
        }
        const std::size_t bit = static_cast<std::size_t>(x) * bitmap.bits;
        const unsigned index = bytes[at + bit / 8] >> (8 - bitmap.bits - bit % 8) & ((1u << bitmap.bits) - 1);
        if (index >= bitmap.palette.size()) refuse_bitmap(source, "a pixel lies outside of its palette");
        samples.insert(samples.end(), bitmap.palette[index].begin(),
                       bitmap.palette[index].begin() + channels);
    }
}

}  // namespace

FileDescription describe_bmp(const SourceFile& source) {
    const Bitmap bitmap = read_header(source);
    return {"bmp", bitmap.width, bitmap.height, bitmap.channels(), 8};
}

Raster decode_bmp(const SourceFile& source) {
    Bitmap bitmap = read_header(source);
    std::vector<std::uint8_t> unpacked;
    if (bitmap.is_in_runs) {
        unpacked = unpack_runs(source, bitmap);
        bitmap.bits = 8;
        bitmap.offset = 0;
        bitmap.row_bytes = static_cast<std::size_t>(bitmap.width);
    }
    const std::vector<std::uint8_t>& bytes = bitmap.is_in_runs ? unpacked : source.bytes;
    std::vector<std::uint8_t> samples;
    samples.reserve(static_cast<std::size_t>(bitmap.width) * bitmap.height * bitmap.channels());
    for (int y = 0; y < bitmap.height; ++y) {
        const int row = bitmap.is_top_first ? y : bitmap.height - 1 - y;
        append_row(bytes, source, bitmap, bitmap.offset + bitmap.row_bytes * row, samples);
    }
    Raster raster{bitmap.width, bitmap.height, bitmap.channels(), 255, kNoData, std::move(samples)};
    if (bitmap.channels() == 4) split_alpha(raster);
    // Many programs leave the fourth byte 0, and no picture is wholly transparent.
    if (std::ranges::all_of(raster.alpha, [](std::uint8_t alpha) { return alpha == 0; })) raster.alpha = {};
    return raster;
}

}  // namespace hexrelief::readers::codec
