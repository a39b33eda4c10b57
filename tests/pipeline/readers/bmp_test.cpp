// Tests Windows bitmaps, made byte by byte.
#include <algorithm>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/image_reader.h"
#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {
namespace {

void put(Bytes& bytes, std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

struct BmpKind {
    int bits = 24;
    std::uint32_t header = 40, compression = 0, colors = 0;
    std::vector<std::uint32_t> masks = {};  // behind 40 bytes of the header
    Bytes palette = {};  // as in the file: blue, green, red, and 0 unless the header is of 12 bytes
    std::int64_t claimed_height = 0;  // instead of the height; negative = top row first
};

// rows: in the order of the file, each filled up to four bytes.
Bytes make_bmp(int width, int height, const Bytes& rows, const BmpKind& kind = {}) {
    const auto rows_at = 14 + kind.header + static_cast<std::uint32_t>(kind.palette.size()) +
                         (kind.header == 40 ? 4 * static_cast<std::uint32_t>(kind.masks.size()) : 0);
    Bytes bytes = to_bytes("BM");
    put(bytes, rows_at + static_cast<std::uint32_t>(rows.size()), 4);
    put(bytes, 0, 4);
    put(bytes, rows_at, 4);
    put(bytes, kind.header, 4);
    const int side = kind.header == 12 ? 2 : 4;
    put(bytes, static_cast<std::uint32_t>(width), side);
    put(bytes, static_cast<std::uint32_t>(kind.claimed_height ? kind.claimed_height : height), side);
    put(bytes, 1, 2);
    put(bytes, static_cast<std::uint32_t>(kind.bits), 2);
    if (kind.header > 12) {
        put(bytes, kind.compression, 4);
        for (int i = 0; i < 3; ++i) put(bytes, 0, 4);
        put(bytes, kind.colors, 4);
        put(bytes, 0, 4);
        for (const std::uint32_t mask : kind.masks) put(bytes, mask, 4);
    }
    bytes.resize(std::max<std::size_t>(bytes.size(), 14 + kind.header), 0);
    return bytes + kind.palette + rows;
}

Image read(const Bytes& bytes) {
    const Folder folder;
    return read_image(folder.write("a.png", bytes));
}

std::string error_for(const Bytes& bytes) {
    return error_of_file("bad.bmp", bytes, [](const auto& path) { read_image(path); });
}

// Two rows of one pixel and its filling, the lower one first: blue, then red.
const Bytes kTwoRows = {255, 0, 0, 0, 0, 0, 255, 0};

TEST(ReadBmp, TheLastRowComesFirstUnlessTheHeightIsNegative) {
    EXPECT_EQ(read(make_bmp(1, 2, kTwoRows)).pixels, (Bytes{255, 0, 0, 0, 0, 255}));
    EXPECT_EQ(read(make_bmp(1, 2, kTwoRows, {.claimed_height = -2})).pixels, (Bytes{0, 0, 255, 255, 0, 0}));
    EXPECT_EQ(read(make_bmp(1, 2, kTwoRows, {.header = 12})).pixels, (Bytes{255, 0, 0, 0, 0, 255}));
    const std::vector<std::uint32_t> no_masks(4, 0);
    for (const std::uint32_t header : {52u, 56u, 64u, 108u, 124u})
        EXPECT_EQ(read(make_bmp(1, 2, kTwoRows, {.header = header})).pixels, (Bytes{255, 0, 0, 0, 0, 255}))
            << header;
}

TEST(ReadBmp, PalettesOfOneFourAndEightBits) {
    const Bytes colors = {3, 2, 1, 0, 30, 20, 10, 0};
    EXPECT_EQ(read(make_bmp(3, 1, {0b01000000, 0, 0, 0}, {.bits = 1, .palette = colors})).pixels,
              (Bytes{1, 2, 3, 10, 20, 30, 1, 2, 3}));
    EXPECT_EQ(read(make_bmp(3, 1, {0x01, 0x10, 0, 0}, {.bits = 4, .colors = 2, .palette = colors})).pixels,
              (Bytes{1, 2, 3, 10, 20, 30, 10, 20, 30}));
    EXPECT_EQ(read(make_bmp(2, 1, {1, 0, 0, 0}, {.bits = 8, .colors = 2, .palette = colors})).pixels,
              (Bytes{10, 20, 30, 1, 2, 3}));
    EXPECT_EQ(read(make_bmp(2, 1, {1, 0, 0, 0}, {.bits = 1, .header = 12, .palette = {3, 2, 1, 30, 20, 10}}))
                  .pixels,
              (Bytes{1, 2, 3, 1, 2, 3}));
}

TEST(ReadBmp, APaletteOfGreysIsGrey) {
    Bytes greys;
    for (int i = 0; i < 256; ++i) put(greys, static_cast<std::uint32_t>(i * 0x010101), 4);
    const Image image = read(make_bmp(2, 1, {7, 200, 0, 0}, {.bits = 8, .palette = greys}));
    EXPECT_EQ(image.channels, 1);
    EXPECT_EQ(image.pixels, (Bytes{7, 200}));
}

TEST(ReadBmp, SixteenBitsByTheirMasks) {
    // 5 bits each: red full, then green full.
    EXPECT_EQ(read(make_bmp(2, 1, {0x00, 0x7c, 0xe0, 0x03}, {.bits = 16})).pixels,
              (Bytes{255, 0, 0, 0, 255, 0}));
    const BmpKind five_six_five{.bits = 16, .compression = 3, .masks = {0xf800, 0x7e0, 0x1f}};
    EXPECT_EQ(read(make_bmp(2, 1, {0x00, 0xf8, 0xe0, 0x07}, five_six_five)).pixels,
              (Bytes{255, 0, 0, 0, 255, 0}));
    EXPECT_EQ(read(make_bmp(1, 1, {0x10, 0x04, 0, 0}, five_six_five)).pixels, (Bytes{0, 130, 132}));
}

TEST(ReadBmp, AlphaWhereTheHeaderHasItsMask) {
    const Bytes row = {1, 2, 3, 0, 4, 5, 6, 255};
    EXPECT_TRUE(read(make_bmp(2, 1, row, {.bits = 32})).alpha.empty()) << "the fourth byte means nothing";
    const BmpKind with_alpha{
        .bits = 32, .header = 56, .compression = 3, .masks = {0xff0000, 0xff00, 0xff, 0xff000000}};
    const Image image = read(make_bmp(2, 1, row, with_alpha));
    EXPECT_EQ(image.pixels, (Bytes{3, 2, 1, 6, 5, 4}));
    EXPECT_EQ(image.alpha, (Bytes{0, 255}));
    EXPECT_TRUE(read(make_bmp(2, 1, {1, 2, 3, 0, 4, 5, 6, 0}, with_alpha)).alpha.empty())
        << "no picture is wholly transparent";
}

TEST(ReadBmp, IsDescribedByItsHeader) {
    const Folder folder;
    const auto description = describe_raster(folder.write("a", make_bmp(1, 2, kTwoRows)));
    ASSERT_TRUE(description);
    EXPECT_EQ(description->format, "bmp");
    EXPECT_EQ(description->height, 2);
    EXPECT_EQ(description->channels, 3);
}

// Indices of greys, the lower row first: runs, pixels one by one with a filling, a step, ends.
TEST(ReadBmp, RunsOfPaletteIndices) {
    BmpKind kind{.bits = 8, .compression = 1, .colors = 16, .palette = {}};
    for (std::uint8_t grey = 0; grey < 16; ++grey) kind.palette = kind.palette + Bytes{grey, grey, grey, 0};
    const Bytes runs = {2, 7, 1, 9, 0, 0, 0, 3, 1, 2, 3, 0, 0, 1};
    EXPECT_EQ(read(make_bmp(3, 2, runs, kind)).pixels, (Bytes{1, 2, 3, 7, 7, 9}));
    EXPECT_EQ(read(make_bmp(3, 2, {1, 5, 0, 2, 1, 1, 1, 6, 0, 1}, kind)).pixels, (Bytes{0, 0, 6, 5, 0, 0}));
    kind.bits = 4;
    kind.compression = 2;
    EXPECT_EQ(read(make_bmp(3, 2, {3, 0x78, 0, 0, 0, 3, 0x12, 0x30, 0, 1}, kind)).pixels,
              (Bytes{1, 2, 3, 7, 8, 7}));
    EXPECT_CONTAINS(error_for(make_bmp(3, 2, {4, 0x78, 0, 1}, kind)), "leaves the picture");
    EXPECT_CONTAINS(error_for(make_bmp(3, 1, {0, 0, 3, 0, 0, 1}, kind)), "leaves the picture");
    EXPECT_CONTAINS(error_for(make_bmp(3, 1, {0, 2, 255, 255, 1, 1, 0, 1}, kind)), "leaves the picture");
    EXPECT_CONTAINS(error_for(make_bmp(20000, 20000, {0, 1}, kind)), "truncated");
    const Bytes whole = {3, 0x78, 0, 0, 0, 3, 0x12, 0x30, 0, 1};
    for (std::size_t length = 0; length < whole.size(); ++length)
        EXPECT_CONTAINS(error_for(make_bmp(3, 2, Bytes(whole.begin(), whole.begin() + length), kind)),
                        "truncated");
}

TEST(ReadBmp, RefusesWhatItDoesNotRead) {
    EXPECT_CONTAINS(error_for(make_bmp(2, 1, {2, 7, 0, 1}, {.bits = 4, .compression = 1})), "uncompressed");
    EXPECT_CONTAINS(error_for(make_bmp(1, 1, Bytes(4, 0), {.header = 64, .compression = 3})), "uncompressed");
    EXPECT_CONTAINS(error_for(make_bmp(1, 1, Bytes(4, 0), {.bits = 2})), "2 bits");
    EXPECT_CONTAINS(error_for(make_bmp(1, 1, Bytes(4, 0), {.bits = 0})), "0 bits");
    EXPECT_CONTAINS(
        error_for(make_bmp(1, 1, Bytes(4, 0), {.bits = 32, .compression = 3, .masks = {0, 1, 2}})),
        "no bits");
}

TEST(ReadBmp, RefusesMalformedFiles) {
    EXPECT_CONTAINS(error_for(make_bmp(0, 1, {})), "0x1");
    EXPECT_CONTAINS(error_for(make_bmp(-1, 1, Bytes(4, 0))), "negative");
    EXPECT_CONTAINS(error_for(make_bmp(0x7fffffff, 0x7fffffff, {})), "limit");
    EXPECT_CONTAINS(error_for(make_bmp(4, 4, {}, {.claimed_height = -0x80000000LL})), "limit");
    EXPECT_CONTAINS(error_for(make_bmp(20000, 20000, Bytes(4, 0))), "truncated");
    EXPECT_CONTAINS(error_for(make_bmp(1, 1, {5, 0, 0, 0}, {.bits = 8, .colors = 1, .palette = Bytes(4)})),
                    "outside of its palette");
    EXPECT_CONTAINS(error_for(make_bmp(1, 1, {}, {.bits = 8, .palette = Bytes(8)})), "palette is truncated");
    const Bytes good = make_bmp(1, 2, kTwoRows);
    for (std::size_t length = 16; length < good.size(); ++length)
        EXPECT_CONTAINS(error_for(Bytes(good.begin(), good.begin() + length)), "truncated");
    Bytes far = good;
    far[10] = far[11] = far[12] = far[13] = 0xff;  // the rows' place
    EXPECT_CONTAINS(error_for(far), "truncated");
}

TEST(ReadBmp, TextThatBeginsAlikeIsNoBitmap) {
    EXPECT_CONTAINS(error_for(to_bytes("BM is the name of a text, and this is one.")), "text");
}

}  // namespace
}  // namespace hexrelief::readers
